#include "distribution/message_sizes.hpp"

#include <algorithm>

#include "distribution/message_tags.hpp"

namespace bulkley {

std::vector<MessageSize> exchange_counts(const Comm& comm, const Neighbours& neighbours,
                                         const std::vector<MessageSize>& outgoing) {
  const std::size_t n = neighbours.ranks().size();
  std::vector<GlobalIndex> there(n, 0), here(n, 0);
  for (const MessageSize& message : outgoing) {
    const auto place = std::lower_bound(neighbours.ranks().begin(), neighbours.ranks().end(), message.rank);
    BULKLEY_ASSERT(place != neighbours.ranks().end() && *place == message.rank);
    there[static_cast<std::size_t>(place - neighbours.ranks().begin())] = message.count;
  }
  std::vector<MPI_Request> requests(2 * n);
  for (std::size_t k = 0; k < n; ++k) {
    const int rank = neighbours.ranks()[k];
    BULKLEY_MPI(MPI_Irecv(&here[k], 1, MPI_INT64_T, rank, message_tag::counts, comm.get(), &requests[k]));
    BULKLEY_MPI(MPI_Isend(&there[k], 1, MPI_INT64_T, rank, message_tag::counts, comm.get(), &requests[n + k]));
  }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(2 * n), requests.data(), MPI_STATUSES_IGNORE));
  std::vector<MessageSize> incoming;
  for (std::size_t k = 0; k < n; ++k)
    if (here[k] > 0) incoming.push_back({neighbours.ranks()[k], here[k]});
  return incoming;
}

std::vector<std::int32_t> trade(const Comm& comm, const std::vector<MessageSize>& outgoing,
                                const std::vector<std::int32_t>& sent, const std::vector<MessageSize>& incoming,
                                int numbers_per_item) {
  GlobalIndex n = 0;
  for (const MessageSize& message : incoming) n += message.count * numbers_per_item;
  std::vector<std::int32_t> received(static_cast<std::size_t>(n));
  std::vector<MPI_Request> requests;
  std::int32_t* to = received.data();
  for (const MessageSize& message : incoming) {
    const auto count = static_cast<int>(message.count * numbers_per_item);
    BULKLEY_MPI(MPI_Irecv(to, count, MPI_INT32_T, message.rank, message_tag::trade, comm.get(), &requests.emplace_back()));
    to += count;
  }
  const std::int32_t* from = sent.data();
  for (const MessageSize& message : outgoing) {
    const auto count = static_cast<int>(message.count * numbers_per_item);
    BULKLEY_MPI(MPI_Isend(from, count, MPI_INT32_T, message.rank, message_tag::trade, comm.get(), &requests.emplace_back()));
    from += count;
  }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
  return received;
}

}  // namespace bulkley
