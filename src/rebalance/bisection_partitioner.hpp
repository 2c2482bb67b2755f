#pragma once
// The partitioner of `bisection` and `hilbert`: no root, and no rank that sees all tiles.

#include "balance/bisection.hpp"
#include "rebalance/merged_census.hpp"
#include "rebalance/partitioner.hpp"
#include "rebalance/rank_range.hpp"

namespace bulkley {

/// The tree that bisected() makes of the tiles of all ranks, cut for cut, and this rank's tiles under it in `records`. A rank
/// sends 3 + n messages for each halving of each region that it is in, n being the rounds of the search for a
/// cut (bisection.cpp), and one with tiles: O(log^2 P) in all. Then all ranks get all cuts, 8 bytes a rank. Precondition:
/// each tile is with one rank, whichever. Collective.
CutTree bisected_together(const Comm& comm, const GridGeometry& grid, Cutting cutting, std::vector<TileRecord>& records,
                          const KeptCuts& kept, SentMessages& sent, RankHalves halves = {});

/// Makes trees of cuts, and follows loads by moving as few cuts as pay. A change is judged by the loads of ranks alone: what
/// it does to their messages is not predicted, and hardly changes where few cuts move.
class BisectionPartitioner final : public Partitioner {
 public:
  explicit BisectionPartitioner(Cutting cutting, RankHalves halves = {}) : cutting_(cutting), halves_(halves) {}

  PartitionProposal find(const Comm& comm, const PartitionRequest& request) override;

 private:
  Cutting cutting_;
  RankHalves halves_;
};

}  // namespace bulkley
