#pragma once
// Which rank works on which tile.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "balance/partition_settings.hpp"
#include "balance/tile_load.hpp"

namespace bulkley {

/// A box of nodes for each rank.
struct Boxes {
  Int3 n_ranks{1, 1, 1};                  ///< process grid
  std::array<std::vector<int>, 3> nodes;  ///< per process along each axis; multiples of tile_width but the last
  double imbalance = 1.0;                 ///< largest over mean load of the boxes, when they were cut

  /// Ranks are numbered z fastest, like nodes.
  int rank_of(const Int3& process) const { return (process[0] * n_ranks[1] + process[1]) * n_ranks[2] + process[2]; }
  /// Whether they are the same boxes, whatever load they were cut for.
  bool operator==(const Boxes& other) const { return nodes == other.nodes; }
};

struct Partition {
  int n_ranks = 1;
  std::vector<std::int32_t> worker;  ///< rank that works on each tile, by TileIndex; some ranks may have none
  std::optional<Boxes> boxes;        ///< none where box_fault
};

/// Their process grid to stand behind a number of ranks, as " (2 x 2 x 2)"; empty if there are none.
std::string boxes_text(const std::optional<Boxes>& boxes);

/// Why the tiles of the grid do not make a box for each rank, as a clause; empty where they do. Not collective.
std::string box_fault(const GridGeometry& grid, int n_ranks);

/// Rank whose box holds the nodes of each tile, by TileIndex. Not collective.
std::vector<std::int32_t> box_owners(const GridGeometry& grid, const Boxes& boxes);

/// Tiles along each axis that may go to different ranks. A node just behind a wall and its image just in front of it have
/// one owner: where they lie in different tiles, which can only be at the upper face, the last layer goes with the one
/// before. No particle belongs to it then. Not collective.
Int3 separable_tiles(const GridGeometry& grid);

/// The rank that sums up the nodes of a tile and updates them: the worker of the tile, or of the one in front of it
/// (separable_tiles).
class NodeOwner {
 public:
  NodeOwner(const GridGeometry& grid, const std::vector<std::int32_t>& worker)
      : grid_(grid), worker_(worker), separable_(separable_tiles(grid)) {}
  std::int32_t operator()(Int3 tile) const {
    for (int axis = 0; axis < 3; ++axis) tile[axis] = tile[axis] < separable_[axis] ? tile[axis] : separable_[axis] - 1;
    return worker_[static_cast<std::size_t>(grid_.tile_index(tile))];
  }

 private:
  const GridGeometry& grid_;
  const std::vector<std::int32_t>& worker_;
  Int3 separable_;
};

/// Largest over mean load at which moving tiles stops, and that a partition can be expected to reach.
inline constexpr double even_enough = 1.02;

/// How a partition came about.
struct PartitionNotes {
  PartitionMethod method = PartitionMethod::uniform;  ///< the one that made it; never `automatic`
  bool evened = false;                                ///< by `automatic`: boxes from which few tiles were moved
  std::vector<std::string> warnings;
};

/// Shares out nodes and tiles among ranks.
///
/// The boxes: equal numbers of tiles along each axis for `uniform`; else cuts that minimise the largest load of a rank,
/// moved towards equal parts where that costs less than 2 %. A tile counts a little more than its load, so that empty space
/// is divided too. All factorisations of n_ranks are tried; of those within 5 % of the smallest largest load the one with
/// the least surface is taken. Every rank owns at least one tile along each axis. The nodes just behind and just in front of
/// a face have one owner. With `present`, its boxes stay while they serve about as well as when they were cut. There are
/// none where the tiles of the grid do not suffice.
///
/// The workers: the owners of the boxes for `uniform` and `ranges`; chunks of a Hilbert curve through the loaded tiles for
/// `hilbert`; parts of their graph with few shared nodes for `metis` (Karypis & Kumar 1998, recursive bisection; then moved
/// towards even loads); for `automatic` the one of these for which `cost` predicts the fastest step, where boxes are evened
/// out (rebalanced) and may be 2 % slower. Parts are numbered for the largest overlap with `present`, or else with the
/// owners. An empty tile goes to the worker of a nearest loaded one. Where fewer tiles are loaded than there are ranks, the
/// surplus ranks have none.
///
/// Deterministic: the same for the same arguments. Throws UsageError when there are no boxes for `uniform` and `ranges`. Not
/// collective; dear for large grids, so that runs do it on the root (share_partition).
Partition make_partition(const GridGeometry& grid, const PartitionSettings& settings, const TileLoad& load, int n_ranks,
                         const Partition* present = nullptr, const CostModel& cost = {}, PartitionNotes* notes = nullptr);

/// `present` with as few tiles moved from rank to rank as bring the largest load near the mean, in two ways: load is handed
/// on from neighbour to neighbour, or goes straight from full ranks to empty ones (src/domain/diffusion.hpp). Not
/// collective.
std::array<Partition, 2> rebalanced(const GridGeometry& grid, const TileLoad& load, const Partition& present);

/// Load of each rank. Not collective.
std::vector<GlobalIndex> rank_loads(const Partition& partition, const TileLoad& load, int n_ranks);

/// Largest over mean of values >= 0 (1 if all are zero). Not collective.
double imbalance(const std::vector<GlobalIndex>& values);

/// Particles in tiles whose worker differs between two partitions. Not collective.
GlobalIndex n_moved(const Partition& from, const Partition& to, const TileLoad& load);

}  // namespace bulkley
