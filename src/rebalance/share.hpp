#pragma once
// What ranks tell each other about tiles: censuses to the root, the root's partition to all.

#include "balance/partition.hpp"
#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// The ranks' censuses as one, on the root; empty elsewhere. A tile may be in several of them. Precondition: the same
/// n_materials on every rank. Collective.
TileCensus gather_census(const Comm& comm, const TileCensus& local);

/// The root's partition on every rank. Collective.
Partition share_partition(const Comm& comm, Partition partition);

}  // namespace bulkley
