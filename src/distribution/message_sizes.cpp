#include "distribution/message_sizes.hpp"

#include <petscsys.h>

#include <algorithm>

#include "bulkley/parallel/petsc.hpp"

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

}  // namespace bulkley
