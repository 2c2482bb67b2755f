#include "rebalance/rank_range.hpp"

#include <algorithm>
#include <limits>

namespace bulkley {

RankRange::RankRange(const Comm& comm, int first, int size, SentMessages& sent)
    : comm_(&comm), first_(first), size_(size), sent_(&sent) {}

RankRange RankRange::half() const {
  const int below = CutTree::n_below(size_);
  return in_lower_half() ? RankRange(*comm_, first_, below, *sent_)
                         : RankRange(*comm_, first_ + below, size_ - below, *sent_);
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

// Ranks of the halves are partners in order. The last rank of an upper half that has one more sends to the last of the lower
// half, and gets nothing.
void RankRange::send_to_other_half(const void* data, std::size_t bytes, MPI_Request& request) {
  const int below = CutTree::n_below(size_), here = comm_->rank() - first_;
  const int to = here < below ? here + below : std::min(here - below, below - 1);
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw RunError("a rank holds more tiles than one message can carry; use more ranks");
  ++sent_->messages;
  sent_->bytes += static_cast<GlobalIndex>(bytes);
  BULKLEY_MPI(MPI_Isend(data, static_cast<int>(bytes), MPI_BYTE, first_ + to, detail::range_tag, comm_->get(), &request));
}

std::vector<int> RankRange::sources() const {
  const int below = CutTree::n_below(size_), here = comm_->rank() - first_;
  if (here >= below) return here - below < below ? std::vector{first_ + here - below} : std::vector<int>{};
  std::vector<int> result{first_ + here + below};
  if (here == below - 1 && size_ > 2 * below) result.push_back(first_ + size_ - 1);
  return result;
}

}  // namespace bulkley
