#pragma once
// The partitioner of `auto`: on the root while that is quick, without one beyond.

#include "rebalance/bisection_partitioner.hpp"
#include "rebalance/root_partitioner.hpp"

namespace bulkley {

/// Asks a RootPartitioner, which tries every method, while at most `most_tiles` hold particles, and a BisectionPartitioner
/// where there are more; once it has, until there are only half as many. A tile counts for each rank that has particles in it. In boxes of
/// more than most_tiles_in_table tiles there is no root either.
class AutomaticPartitioner final : public Partitioner {
 public:
  explicit AutomaticPartitioner(const PartitionSettings& settings, std::size_t most_tiles = most_tiles_on_root)
      : most_tiles_(static_cast<GlobalIndex>(most_tiles)),
        on_root_(settings),
        together_(Cutting::planes, {std::max(1, settings.ranks_per_node)}) {}

 private:
  PartitionProposal find(const Comm& comm, const PartitionRequest& request) override;

  GlobalIndex most_tiles_;
  bool has_root_ = true;
  RootPartitioner on_root_;
  BisectionPartitioner together_;
};

}  // namespace bulkley
