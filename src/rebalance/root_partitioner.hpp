#pragma once
// The partitioner of `metis`, and of `auto` up to some size: the root sees the whole census, and every rank gets its map.

#include "rebalance/partitioner.hpp"

namespace bulkley {

/// Gathers the censuses on the root, which makes a map by make_partition or finds a worthwhile_change, and broadcasts
/// it. Takes memory for all tiles with particles on the root, and one message from every rank to it.
class RootPartitioner final : public Partitioner {
 public:
  explicit RootPartitioner(const PartitionSettings& settings) : settings_(settings) {}

  PartitionProposal find(const Comm& comm, const PartitionRequest& request) override;

 private:
  PartitionProposal find_on_root(const PartitionRequest& request, const TileCensus& census, int n_ranks);

  PartitionSettings settings_;
  double fresh_exchange_ = -1.0;  ///< see worthwhile_change, s; the root's. Below zero: not known yet
};

}  // namespace bulkley
