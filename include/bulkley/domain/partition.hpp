#pragma once
// Who owns which nodes (DMDA ownership ranges) and who works on which tile (worker map): two separate things.

#include <array>
#include <span>
#include <vector>

#include "bulkley/domain/settings.hpp"
#include "bulkley/kernel/tile.hpp"

namespace bulkley {

struct Partition {
  Int3 n_ranks{1, 1, 1};                  ///< process grid of the DMDA
  std::array<std::vector<int>, 3> nodes;  ///< nodes per process along each axis; multiples of tile_width but the last
  std::vector<std::int32_t> worker;       ///< rank that works on each tile, by TileIndex

  /// Ranks are numbered as the DMDA of Grid numbers them: z fastest, like its nodes.
  int rank_of(const Int3& process) const { return (process[0] * n_ranks[1] + process[1]) * n_ranks[2] + process[2]; }
};

/// Chooses process grid, ownership ranges and workers for `load` = particles per tile (size n_tiles).
/// `uniform`: equal numbers of tiles along each axis. `ranges`: cuts chosen to minimise the largest load of a rank, then
/// moved towards equal parts where that costs less than 2 %; a tile counts a little more than its particles. So empty space
/// is divided too. All factorisations of n_ranks are tried; among those within 5 % of the smallest largest load, the one
/// with the least surface between ranks is taken. Every rank owns at least one tile along each axis. Workers are the DMDA
/// owners. The nodes just behind and just in front of a face have one owner. Deterministic: the same on every rank that passes the same load.
/// Throws UsageError when the grid has too few tiles for n_ranks. Not collective.
Partition make_partition(const GridGeometry& grid, const PartitionSettings& settings, std::span<const GlobalIndex> load,
                         int n_ranks);

/// Largest over mean load of the ranks that `partition` gives (1 for no load); `load` by TileIndex. Not collective.
double imbalance(const Partition& partition, std::span<const GlobalIndex> load, int n_ranks);

}  // namespace bulkley
