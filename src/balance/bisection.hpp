#pragma once
// Recursive bisection of loaded tiles with ragged cuts, or of the run of a Hilbert curve through them: the same code on one process
// and on the ranks of a region together.

#include <optional>
#include <span>
#include <vector>

#include "balance/region_sums.hpp"
#include "balance/tile_load.hpp"
#include "grid/cut_tree.hpp"

namespace bulkley {

/// A loaded tile.
struct TileRecord {
  Int3 at;             ///< its coordinates, or its place where the curve is cut
  std::int32_t owner;  ///< under the present map; for whoever wants to know. Not used here
  GlobalIndex weight;  ///< > 0; ps
  GlobalIndex count;   ///< particles
};

/// Which cuts of an earlier tree stay.
struct KeptCuts {
  /// A cut stays where on both sides the load a rank is at most (1 + tolerance x depth / largest depth) of the mean of all
  /// ranks: cuts near the root, whose shift moves material through everything below them, hold tighter sums than the last
  /// ones, and rarely need to move. Below zero: none stays. A cut that moves keeps its axis while another has not 20 % fewer faces:
  /// across another axis it would take everything below it along.
  static constexpr double usual_tolerance = 0.05, tight_tolerance = 0.02, no_tolerance = -1.0;
  const CutTree* present = nullptr;  ///< of as many ranks, of the same Cutting and RankHalves
  double tolerance = usual_tolerance;
};

/// Cuts regions of ranks; the same for every participant.
class Bisection {
 public:
  /// `total`: load of all ranks.
  Bisection(const GridGeometry& grid, Cutting cutting, RankHalves halves, int n_ranks, GlobalIndex total,
            const KeptCuts& kept = {})
      : n_tiles_{grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)},
        cutting_(cutting),
        halves_(halves),
        n_ranks_(n_ranks),
        total_(total),
        kept_(kept) {}

  /// The cut of the ranks first .. first + n_ranks - 1, of at least two, `depth` levels below all ranks; `records`: this
  /// participant's part of the region's tiles, in any order. The lower side gets its ranks' share of the load, to within half
  /// a tile, and no side fewer tiles than ranks unless it must. Of the three axes the one with the fewest faces
  /// of loaded tiles below the cut to tiles above it is taken, whether those are loaded or not: so many footprints reach
  /// across. A curve has one axis. In empty space the cut lies in the middle. The presence of a tile at a place in the grid is all that decides, so
  /// that it does not matter who holds which record. Collective among the participants.
  Cut cut(std::span<const TileRecord> records, int first, int n_ranks, int depth, RegionSums& sums) const;

 private:
  struct Region;
  Region survey(std::span<const TileRecord> records, const std::optional<Cut>& old, RegionSums& sums) const;
  bool serves(const Region& region, int n_ranks, int depth) const;
  Cut best_cut(std::span<const TileRecord> records, const Region& region, int n_ranks, const std::optional<Cut>& old,
               RegionSums& sums) const;

  Int3 n_tiles_;
  Cutting cutting_;
  RankHalves halves_;
  int n_ranks_;
  GlobalIndex total_;
  KeptCuts kept_;
};

/// The tiles of a load; without owners.
std::vector<TileRecord> records_of(const GridGeometry& grid, Cutting cutting, const TileLoad& load);

/// Plane cuts through the middle, across the longest axis: for grids without any load, where a curve would leave ranks of a flat
/// box without tiles. Not collective.
CutTree even_cuts(const GridGeometry& grid, int n_ranks, RankHalves halves = {});

/// The whole tree, from all tiles; even_cuts, or those that are there, where none is loaded. Not collective.
CutTree bisected(const GridGeometry& grid, Cutting cutting, const TileLoad& load, int n_ranks, const KeptCuts& kept = {},
                 RankHalves halves = {});

}  // namespace bulkley
