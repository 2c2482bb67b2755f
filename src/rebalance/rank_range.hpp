#pragma once
// What consecutive ranks do together without a communicator of their own: sums, and records that go to one half of them.

#include <cstddef>
#include <cstring>
#include <functional>
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
/// in proportion to all ranks, at every level of a bisection. Every message begins with a number that all ranks have drawn for
/// what they do together: one of something else ends all ranks.
class RankRange final : public RegionSums {
 public:
  /// All ranks of `comm`. It and `sent`, which counts, must outlive this. Collective, without a message.
  RankRange(const Comm& comm, SentMessages& sent, RankHalves halves = {});

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
  RankRange(const RankRange& whole, int first, int size);
  /// A message for the other half: what this is about, then the data.
  std::vector<std::byte> letter(const void* data, std::size_t bytes) const;
  void send_to_other_half(const std::vector<std::byte>& letter, MPI_Request& request);
  /// The messages from the other half, without their beginnings, to `take(bytes, n)`.
  void receive_from_other_half(const std::function<void(const std::byte*, std::size_t)>& take);
  std::vector<int> sources() const;

  const Comm* comm_;
  int first_, size_;
  GlobalIndex number_;
  RankHalves halves_;
  SentMessages* sent_;
  std::vector<GlobalIndex> mine_, others_;  ///< number, values
};

template <class Item, class Below>
void RankRange::divide(std::vector<Item>& items, const Below& below) {
  static_assert(std::is_trivially_copyable_v<Item>);
  std::vector<Item> kept, given;
  for (const Item& item : items) (below(item) == in_lower_half() ? kept : given).push_back(item);
  const std::vector<std::byte> sent = letter(given.data(), given.size() * sizeof(Item));
  MPI_Request request = MPI_REQUEST_NULL;
  send_to_other_half(sent, request);
  receive_from_other_half([&kept](const std::byte* bytes, std::size_t n) {
    const std::size_t n_kept = kept.size();
    kept.resize(n_kept + n / sizeof(Item));
    if (n > 0) std::memcpy(kept.data() + n_kept, bytes, n);
  });
  BULKLEY_MPI(MPI_Wait(&request, MPI_STATUS_IGNORE));
  items = std::move(kept);
}

}  // namespace bulkley
