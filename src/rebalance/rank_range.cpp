#include "rebalance/rank_range.hpp"

#include <algorithm>
#include <limits>

namespace bulkley {

RankRange::RankRange(const Comm& comm, int first, int size, SentMessages& sent, RankHalves halves)
    : comm_(&comm), first_(first), size_(size), halves_(halves), sent_(&sent) {}

RankRange RankRange::half() const {
  return in_lower_half() ? RankRange(*comm_, first_, middle() - first_, *sent_, halves_)
                         : RankRange(*comm_, middle(), first_ + size_ - middle(), *sent_, halves_);
}

void RankRange::combine(std::span<GlobalIndex> values, std::size_t n_added) {
  others_.resize(values.size());
  const int n = static_cast<int>(values.size()), here = comm_->rank() - first_;
  const auto count = [&] {
    ++sent_->messages;
    sent_->bytes += static_cast<GlobalIndex>(values.size_bytes());
  };
  const auto send = [&](int to) {
    count();
    BULKLEY_MPI(MPI_Send(values.data(), n, MPI_INT64_T, first_ + to, detail::range_tag, comm_->get()));
  };
  const auto receive = [&](GlobalIndex* into, int from) {
    BULKLEY_MPI(MPI_Recv(into, n, MPI_INT64_T, first_ + from, detail::range_tag, comm_->get(), MPI_STATUS_IGNORE));
  };
  const auto merge = [&] {
    for (std::size_t v = 0; v < n_added; ++v) values[v] += others_[v];
    for (std::size_t v = n_added; v < values.size(); ++v) values[v] = std::min(values[v], others_[v]);
  };
  // Those beyond a power of two hand their numbers to a partner, and get the result from it.
  const int whole = static_cast<int>(std::bit_floor(static_cast<unsigned>(size_))), rest = size_ - whole;
  if (here >= whole) {
    send(here - whole);
    receive(values.data(), here - whole);
    return;
  }
  if (here < rest) {
    receive(others_.data(), here + whole);
    merge();
  }
  for (int distance = 1; distance < whole; distance *= 2) {
    const int partner = first_ + (here ^ distance);
    count();
    BULKLEY_MPI(MPI_Sendrecv(values.data(), n, MPI_INT64_T, partner, detail::range_tag, others_.data(), n, MPI_INT64_T,
                             partner, detail::range_tag, comm_->get(), MPI_STATUS_IGNORE));
    merge();
  }
  if (here < rest) send(here + whole);
}

// Ranks of the halves are partners in order, and the larger half's go round the smaller one's.
void RankRange::send_to_other_half(const void* data, std::size_t bytes, MPI_Request& request) {
  const int below = middle() - first_, above = size_ - below, here = comm_->rank() - first_;
  const int to = here < below ? below + here % above : (here - below) % below;
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw RunError("a rank holds more tiles than one message can carry; use more ranks");
  ++sent_->messages;
  sent_->bytes += static_cast<GlobalIndex>(bytes);
  BULKLEY_MPI(MPI_Isend(data, static_cast<int>(bytes), MPI_BYTE, first_ + to, detail::range_tag, comm_->get(), &request));
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
