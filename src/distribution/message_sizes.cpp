#include "distribution/message_sizes.hpp"

#include <petscsys.h>

#include <algorithm>

#include "bulkley/parallel/petsc.hpp"
#include "distribution/message_tags.hpp"

namespace bulkley {

std::vector<MessageSize> exchange_counts(const Comm& comm, const std::vector<MessageSize>& outgoing) {
  std::vector<PetscMPIInt> ranks;
  std::vector<GlobalIndex> counts;
  for (const MessageSize& message : outgoing) {
    ranks.push_back(message.rank);
    counts.push_back(message.count);
  }
  PetscMPIInt n_sources = 0;
  PetscMPIInt* sources = nullptr;
  GlobalIndex* source_counts = nullptr;
  BULKLEY_PETSC(PetscCommBuildTwoSided(comm.get(), 1, MPI_INT64_T, static_cast<PetscMPIInt>(ranks.size()), ranks.data(),
                                       counts.data(), &n_sources, &sources, &source_counts));
  std::vector<MessageSize> incoming;
  for (PetscMPIInt s = 0; s < n_sources; ++s) incoming.push_back({sources[s], source_counts[s]});
  BULKLEY_PETSC(PetscFree(sources));
  BULKLEY_PETSC(PetscFree(source_counts));
  std::sort(incoming.begin(), incoming.end(), [](const MessageSize& a, const MessageSize& b) { return a.rank < b.rank; });
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
