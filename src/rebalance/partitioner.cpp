#include "rebalance/partitioner.hpp"

#include <algorithm>
#include <array>

#include "parallel/node_layout.hpp"
#include "rebalance/automatic_partitioner.hpp"
#include "rebalance/box_partitioner.hpp"

namespace bulkley {

PartitionProposal Partitioner::propose(const Comm& comm, const PartitionRequest& request) {
  PartitionProposal proposal = find(comm, request);
  // What all ranks must have alike, each number with its negative: one maximum then shows any difference.
  std::array<GlobalIndex, 6> alike{};
  if (proposal.partition) {
    const TileMap& map = proposal.partition->map;
    const bool fits = map.n_ranks() == comm.size() && map.n_tiles() == request.grid.n_tiles();
    alike[0] = fits ? 1 : 2;
    alike[1] = static_cast<GlobalIndex>(map.fingerprint() >> 1);  // so that its negative exists
  }
  alike[2] = proposal.busiest_moves;
  for (std::size_t n = 0; n < 3; ++n) alike[3 + n] = -alike[n];
  std::array<GlobalIndex, 6> largest = alike;
  BULKLEY_MPI(MPI_Allreduce(alike.data(), largest.data(), 6, MPI_INT64_T, MPI_MAX, comm.get()));
  for (std::size_t n = 0; n < 3; ++n)
    if (largest[n] != -largest[3 + n]) throw RunError("the partitioner proposes different maps on different ranks");
  if (largest[0] == 2) throw RunError("the partitioner proposes a map for another grid or number of ranks");
  return proposal;
}

std::unique_ptr<Partitioner> make_partitioner(const Comm& comm, PartitionSettings settings) {
  if (settings.ranks_per_node == 0) settings.ranks_per_node = node_layout(comm).ranks_per_node;
  const RankHalves halves{std::max(1, settings.ranks_per_node)};
  switch (settings.method) {
    case PartitionMethod::uniform:
      return std::make_unique<BoxPartitioner>(true);
    case PartitionMethod::ranges:
      return std::make_unique<BoxPartitioner>(false);
    case PartitionMethod::hilbert:
      return std::make_unique<BisectionPartitioner>(Cutting::curve, halves);
    case PartitionMethod::bisection:
      return std::make_unique<BisectionPartitioner>(Cutting::planes, halves);
    case PartitionMethod::metis:
      return std::make_unique<RootPartitioner>(settings);
    case PartitionMethod::automatic:
      break;
  }
  return std::make_unique<AutomaticPartitioner>(settings);
}

}  // namespace bulkley
