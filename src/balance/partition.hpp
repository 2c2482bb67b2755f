#pragma once
// Which rank owns which tile.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "balance/partition_settings.hpp"
#include "balance/region_sums.hpp"
#include "balance/tile_load.hpp"
#include "grid/tile_map.hpp"

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
  TileMap map;                 ///< owners of the tiles
  std::optional<Boxes> boxes;  ///< none where box_fault
};

/// Their process grid as text behind a number of ranks: " (2 x 2 x 2)"; empty if there are none.
std::string boxes_text(const std::optional<Boxes>& boxes);

/// Why the tiles of the grid do not make a box for each rank, as a clause; empty where they do. Not collective.
std::string box_fault(const GridGeometry& grid, int n_ranks);

/// The map that gives each tile to the rank whose box holds its nodes. Not collective.
TileMap map_of_boxes(const GridGeometry& grid, const Boxes& boxes);

/// Largest over mean load at which moving tiles stops, and that a partition can be expected to reach.
inline constexpr double target_imbalance = 1.02;

/// `automatic` takes `bisection`, which needs no root, where more tiles than this hold particles: 2 x 10^8 particles, for which a look
/// at the balance on the root takes two seconds.
inline constexpr std::size_t most_tiles_on_root = 400'000;

/// It also does where there are more ranks than this, all of whom the root would hear and whose messages it would predict.
inline constexpr int most_ranks_of_root = 4096;

/// And where the box has more tiles than this, empty ones included: what it makes on the root may be a table of their owners, 16 MiB on
/// every rank.
inline constexpr TileIndex most_tiles_in_table = TileIndex{1} << 22;

/// How a partition came about.
struct PartitionNotes {
  PartitionMethod method = PartitionMethod::uniform;  ///< the one that made it; never `automatic`
  bool rebalanced = false;                            ///< by `automatic`: boxes from which few tiles were moved
  bool spread = false;                                ///< by `automatic`: cuts, but empty tiles go to a nearest owner
  std::vector<std::string> warnings = {};
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
/// The map: that of the boxes for `uniform` and `ranges`; runs of a Hilbert curve for `hilbert` and the regions of recursive cuts for
/// `bisection`, where cuts of `present` stay while they serve (recut), and no boxes are cut;
/// parts of their graph with few shared nodes for `metis` (Karypis & Kumar 1998, recursive bisection; then moved towards
/// equal loads); for `automatic` the one of these for which `cost` predicts the fastest step, where boxes are rebalanced and
/// may be 2 % slower, up to most_tiles_on_root, most_ranks_of_root and most_tiles_in_table. Parts of METIS are numbered for the largest overlap with `present`; without
/// it as they come, near ones by near numbers, so that few bytes leave a node of ranks that follow each other. An empty tile
/// goes to the owner of a nearest loaded one, but under `hilbert` and `bisection` to the run or region that it lies in, unless `automatic` finds a
/// nearest owner faster. Where fewer tiles are loaded than there are ranks, the surplus ranks have none.
///
/// Deterministic: the same for the same arguments. Throws UsageError when there are no boxes for `uniform` and `ranges`. Not
/// collective; expensive for large grids, so that runs do it on the root alone (RootPartitioner).
Partition make_partition(const GridGeometry& grid, const PartitionSettings& settings, const TileLoad& load, int n_ranks,
                         const Partition* present = nullptr, const CostModel& cost = {}, PartitionNotes* notes = nullptr);

/// The boxes of `uniform` or `ranges` and their map, of a load of which every participant has a part (cut_boxes). Throws UsageError where
/// there are none. Collective among the participants.
Partition partition_of_boxes(const GridGeometry& grid, bool uniform, const TileLoad& load, int n_ranks, RegionSums& sums);

/// `present` with as few tiles moved from rank to rank as bring the largest load near the mean, in two ways: load is handed
/// on from neighbour to neighbour, or goes straight from overloaded ranks to empty ones (diffusion.hpp). Not
/// collective.
std::array<Partition, 2> rebalanced(const GridGeometry& grid, const TileLoad& load, const Partition& present);

/// `present` with only those cuts moved that leave more load on a side than `tolerance` allows (KeptCuts); none where its map
/// is not a tree of cuts. Not collective.
std::optional<Partition> recut(const GridGeometry& grid, const TileLoad& load, const Partition& present, double tolerance);

/// Largest over mean of values >= 0 (1 if all are zero). Not collective.
double imbalance(const std::vector<GlobalIndex>& values);

/// Particles in tiles whose owner differs between two maps. Not collective.
GlobalIndex n_moved(const TileMap& from, const TileMap& to, const TileLoad& load);

/// Particles that the busiest rank sends or receives in going from one map to the other. Not collective.
GlobalIndex busiest_moves(const TileMap& from, const TileMap& to, const TileLoad& load);

}  // namespace bulkley
