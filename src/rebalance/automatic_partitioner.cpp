#include "rebalance/automatic_partitioner.hpp"

namespace bulkley {

PartitionProposal AutomaticPartitioner::find(const Comm& comm, const PartitionRequest& request) {
  const GlobalIndex n_tiles = sum_global(comm, static_cast<GlobalIndex>(request.census.size()));
  has_root_ = n_tiles <= (has_root_ ? most_tiles_ : most_tiles_ / 2);
  if (request.grid.n_tiles() > most_tiles_in_table || comm.size() > most_ranks_of_root) has_root_ = false;
  return has_root_ ? on_root_.find(comm, request) : together_.find(comm, request);
}

}  // namespace bulkley
