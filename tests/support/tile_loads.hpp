#pragma once
// Grids, loads of tiles and judgements that tests of partitions share.

#include <algorithm>
#include <random>
#include <vector>

#include "balance/partition.hpp"

namespace bulkley {

inline GridGeometry grid_of_cells(const Int3& n_cells, const std::array<bool, 3>& periodic = {false, false, false}) {
  GridGeometry grid;
  grid.cell_size = 0.1;
  grid.n_cells = n_cells;
  grid.periodic = periodic;
  return grid;
}

/// A third of the tiles, with up to 600 particles.
inline std::vector<GlobalIndex> random_load(const GridGeometry& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<GlobalIndex> load(static_cast<std::size_t>(grid.n_tiles()));
  for (GlobalIndex& tile : load) tile = random() % 3 == 0 ? random() % 600 : 0;
  return load;
}

/// 512 particles in each tile of a ball that is not in the middle of the grid.
inline std::vector<GlobalIndex> ball_load(const GridGeometry& grid) {
  std::vector<GlobalIndex> load(static_cast<std::size_t>(grid.n_tiles()), 0);
  const Vec3 centre = Vec3(0.3 * grid.n_tiles(0), 0.35 * grid.n_tiles(1), 0.28 * grid.n_tiles(2));
  const double radius = 0.25 * grid.n_tiles(0);
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
    const Int3 at = grid.tile_coordinates(tile);
    if ((Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5) - centre).norm() < radius) load[static_cast<std::size_t>(tile)] = 512;
  }
  return load;
}

/// Drops of eight tiles that do not touch, and single tiles.
inline std::vector<GlobalIndex> scattered_load(const GridGeometry& grid) {
  std::vector<GlobalIndex> load(static_cast<std::size_t>(grid.n_tiles()), 0);
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
    const Int3 at = grid.tile_coordinates(tile);
    const bool drop = at[0] % 4 < 2 && at[1] % 4 < 2 && at[2] % 4 < 2;
    const bool single = at[0] % 4 == 3 && at[1] % 8 == 3 && at[2] % 4 == 3;
    if (drop || single) load[static_cast<std::size_t>(tile)] = 100 + 37 * (tile % 11);
  }
  return load;
}

inline PartitionSettings by(PartitionMethod method) {
  PartitionSettings settings;
  settings.method = method;
  return settings;
}

/// Largest over mean load of the ranks.
inline double uneven(const Partition& partition, const TileLoad& load) {
  return imbalance(rank_loads(partition, load, partition.n_ranks));
}

inline int n_without_load(const Partition& partition, const TileLoad& load) {
  const std::vector<GlobalIndex> loads = rank_loads(partition, load, partition.n_ranks);
  return static_cast<int>(std::count(loads.begin(), loads.end(), 0));
}

}  // namespace bulkley
