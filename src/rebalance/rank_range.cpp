#include "rebalance/rank_range.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace bulkley {

namespace {
constexpr int range_tag = 11;
}  // namespace

RankRange::RankRange(const Comm& comm, SentMessages& sent, RankHalves halves)
    : comm_(&comm), first_(0), size_(comm.size()), number_(comm.draw_number()), halves_(halves), sent_(&sent) {}

RankRange::RankRange(const RankRange& whole, int first, int size)
    : comm_(whole.comm_), first_(first), size_(size), number_(whole.number_), halves_(whole.halves_), sent_(whole.sent_) {}

RankRange RankRange::half() const {
  return in_lower_half() ? RankRange(*this, first_, middle() - first_)
                         : RankRange(*this, middle(), first_ + size_ - middle());
}

void RankRange::combine(std::span<GlobalIndex> values, std::size_t n_added) {
  mine_.resize(1 + values.size());
  others_.resize(1 + values.size());
  mine_[0] = number_;
  std::copy(values.begin(), values.end(), mine_.begin() + 1);
  const int n = static_cast<int>(mine_.size()), here = comm_->rank() - first_;
  const auto count = [&] {
    ++sent_->messages;
    sent_->bytes += static_cast<GlobalIndex>(mine_.size() * sizeof(GlobalIndex));
  };
  const auto send = [&](int to) {
    count();
    BULKLEY_MPI(MPI_Send(mine_.data(), n, MPI_INT64_T, first_ + to, range_tag, comm_->get()));
  };
  const auto receive = [&](std::vector<GlobalIndex>& into, int from) {
    BULKLEY_MPI(MPI_Recv(into.data(), n, MPI_INT64_T, first_ + from, range_tag, comm_->get(), MPI_STATUS_IGNORE));
    expect_number(*comm_, joint_work, first_ + from, into[0], number_);
  };
  const auto merge = [&] {
    for (std::size_t v = 1; v <= n_added; ++v) mine_[v] += others_[v];
    for (std::size_t v = 1 + n_added; v < mine_.size(); ++v) mine_[v] = std::min(mine_[v], others_[v]);
  };
  // Those beyond a power of two hand their numbers to a partner, and get the result from it.
  const int whole = static_cast<int>(std::bit_floor(static_cast<unsigned>(size_))), rest = size_ - whole;
  if (here >= whole) {
    send(here - whole);
    receive(mine_, here - whole);
    std::copy(mine_.begin() + 1, mine_.end(), values.begin());
    return;
  }
  if (here < rest) {
    receive(others_, here + whole);
    merge();
  }
  for (int distance = 1; distance < whole; distance *= 2) {
    const int partner = first_ + (here ^ distance);
    count();
    BULKLEY_MPI(MPI_Sendrecv(mine_.data(), n, MPI_INT64_T, partner, range_tag, others_.data(), n, MPI_INT64_T, partner,
                             range_tag, comm_->get(), MPI_STATUS_IGNORE));
    expect_number(*comm_, joint_work, partner, others_[0], number_);
    merge();
  }
  if (here < rest) send(here + whole);
  std::copy(mine_.begin() + 1, mine_.end(), values.begin());
}

std::vector<std::byte> RankRange::letter(const void* data, std::size_t bytes) const {
  std::vector<std::byte> result(sizeof number_ + bytes);
  std::memcpy(result.data(), &number_, sizeof number_);
  if (bytes > 0) std::memcpy(result.data() + sizeof number_, data, bytes);
  return result;
}

// Ranks of the halves are partners in order, and the larger half's go round the smaller one's.
void RankRange::send_to_other_half(const std::vector<std::byte>& letter, MPI_Request& request) {
  const int below = middle() - first_, above = size_ - below, here = comm_->rank() - first_;
  const int to = here < below ? below + here % above : (here - below) % below;
  if (letter.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw RunError("a rank holds more tiles than one message can carry; use more ranks");
  ++sent_->messages;
  sent_->bytes += static_cast<GlobalIndex>(letter.size());
  BULKLEY_MPI(
      MPI_Isend(letter.data(), static_cast<int>(letter.size()), MPI_BYTE, first_ + to, range_tag, comm_->get(), &request));
}

void RankRange::receive_from_other_half(const std::function<void(const std::byte*, std::size_t)>& take) {
  std::vector<std::byte> letter;
  for (const int source : sources()) {
    MPI_Message message;
    MPI_Status status;
    int bytes = 0;
    BULKLEY_MPI(MPI_Mprobe(source, range_tag, comm_->get(), &message, &status));
    BULKLEY_MPI(MPI_Get_count(&status, MPI_BYTE, &bytes));
    letter.resize(static_cast<std::size_t>(bytes));
    BULKLEY_MPI(MPI_Mrecv(letter.data(), bytes, MPI_BYTE, &message, &status));
    GlobalIndex number = 0;
    std::memcpy(&number, letter.data(), sizeof number);
    expect_number(*comm_, joint_work, source, number, number_);
    take(letter.data() + sizeof number, letter.size() - sizeof number);
  }
}

std::vector<int> RankRange::sources() const {
  const int below = middle() - first_, above = size_ - below, here = comm_->rank() - first_;
  const bool low = here < below;
  const int mine = low ? below : above, others = low ? above : below, first_other = low ? middle() : first_;
  std::vector<int> result;
  for (int other = low ? here : here - below; other < others; other += mine) result.push_back(first_other + other);
  return result;
}

}  // namespace bulkley
