#pragma once
// How the work is divided among ranks, table [partition] of a scene.

namespace bulkley {

enum class PartitionMethod {
  uniform,    ///< equal numbers of tiles per rank along each axis
  ranges,     ///< boxes cut for the smallest largest load
  hilbert,    ///< chunks of a Hilbert curve through the tiles that hold particles
  bisection,  ///< regions by recursive cuts of equal load across the axis that leaves the fewest common nodes
  metis,      ///< parts of the graph of those tiles
  automatic,  ///< whichever is predicted to be fastest, as long as a change pays
};

struct PartitionSettings {
  PartitionMethod method = PartitionMethod::automatic;
  int decision_interval = 100;  ///< `automatic`, `bisection`: steps between imbalance checks, at least; 0: no checks
  int remake_interval = 0;      ///< steps between two new maps, whether they pay or not; 0: none
  int ranks_per_node = 0;       ///< consecutive ranks that share a node; 0: as MPI says (make_partitioner), else not known
};

}  // namespace bulkley
