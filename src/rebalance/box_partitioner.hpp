#pragma once
// The partitioner of `uniform` and `ranges`: no root, and no rank that sees all tiles.

#include "rebalance/partitioner.hpp"

namespace bulkley {

/// Makes the boxes that make_partition makes of the tiles of all ranks, the same numbers. Ranks add up layers of boxes (cut_boxes),
/// after each tile has been put together at one rank; `uniform` sends nothing. A change need not pay: boxes that fit the particles better
/// replace the present ones.
class BoxPartitioner final : public Partitioner {
 public:
  explicit BoxPartitioner(bool uniform) : uniform_(uniform) {}

 private:
  PartitionProposal find(const Comm& comm, const PartitionRequest& request) override;

  bool uniform_;
};

}  // namespace bulkley
