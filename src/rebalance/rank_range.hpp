#pragma once
// What consecutive ranks do together without a communicator of their own: sums, and records that go to one half of them.

#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "balance/bisection.hpp"
#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// What a rank has sent.
struct SentMessages {
  GlobalIndex messages = 0, bytes = 0;
};

/// The ranks first .. first + size - 1 of a communicator. No communicator is made for them: splitting one costs time and memory
/// in proportion to all ranks, at every level of a bisection.
class RankRange final : public RegionSums {
 public:
  /// `comm` and `sent`, which counts, must outlive this. This rank is one of them. Not collective.
  RankRange(const Comm& comm, int first, int size, SentMessages& sent, RankHalves halves = {});

  int first() const { return first_; }
  int size() const { return size_; }
  /// The half of them that this rank is in. Precondition: size() > 1.
  RankRange half() const;
  /// First rank of the upper half. Precondition: size() > 1.
  int middle() const { return first_ + halves_.n_below(size_); }
  bool in_lower_half() const { return comm_->rank() < middle(); }

  /// By recursive doubling: log2(size) messages, one more where the size is no power of two. Collective among the ranks.
  void combine(std::span<GlobalIndex> values, std::size_t n_added) override;

  /// Leaves in `items` those for this rank's half, its own and some of the other half's; which rank of a half gets an item is not
  /// said. `below(item)`: it goes to the lower half. Each rank sends one message to the other half. Item: a plain
  /// type without padding. Collective among the ranks.
  template <class Item, class Below>
  void divide(std::vector<Item>& items, const Below& below);

 private:
  void send_to_other_half(const void* data, std::size_t bytes, MPI_Request& request);
  /// Calls room(bytes) for each message from the other half; the message goes where it says.
  template <class Room>
  void receive_from_other_half(const Room& room);
  std::vector<int> sources() const;

  const Comm* comm_;
  int first_, size_;
  RankHalves halves_;
  SentMessages* sent_;
  std::vector<GlobalIndex> others_;
};

namespace detail {
constexpr int range_tag = 11;
}

template <class Item, class Below>
void RankRange::divide(std::vector<Item>& items, const Below& below) {
  static_assert(std::is_trivially_copyable_v<Item>);
  std::vector<Item> kept, given;
  for (const Item& item : items) (below(item) == in_lower_half() ? kept : given).push_back(item);
  MPI_Request request = MPI_REQUEST_NULL;
  send_to_other_half(given.data(), given.size() * sizeof(Item), request);
  receive_from_other_half([&kept](std::size_t bytes) {
    const std::size_t n = kept.size();
    kept.resize(n + bytes / sizeof(Item));
    return static_cast<void*>(kept.data() + n);
  });
  BULKLEY_MPI(MPI_Wait(&request, MPI_STATUS_IGNORE));
  items = std::move(kept);
}

template <class Room>
void RankRange::receive_from_other_half(const Room& room) {
  for (const int source : sources()) {
    MPI_Message message;
    MPI_Status status;
    int bytes = 0;
    BULKLEY_MPI(MPI_Mprobe(source, detail::range_tag, comm_->get(), &message, &status));
    BULKLEY_MPI(MPI_Get_count(&status, MPI_BYTE, &bytes));
    BULKLEY_MPI(MPI_Mrecv(room(static_cast<std::size_t>(bytes)), bytes, MPI_BYTE, &message, &status));
  }
}

}  // namespace bulkley
