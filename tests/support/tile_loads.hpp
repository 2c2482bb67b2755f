#pragma once
// Grids, loads and maps of tiles that tests of partitions share.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "balance/partition.hpp"

namespace bulkley {

/// A grid to test on.
struct GridShape {
  const char* name;
  Int3 n_cells;
  std::array<bool, 3> periodic;
};

inline GridGeometry grid_of_cells(const Int3& n_cells, const std::array<bool, 3>& periodic = {false, false, false}) {
  GridGeometry grid;
  grid.cell_size = 0.1;
  grid.n_cells = n_cells;
  grid.periodic = periodic;
  return grid;
}

/// The tiles of one rank, ascending.
inline std::vector<TileIndex> owned_tiles(const TileMap& map, std::int32_t rank) {
  std::vector<TileIndex> tiles;
  for (TileIndex tile = 0; tile < map.n_tiles(); ++tile)
    if (map.owner(tile) == rank) tiles.push_back(tile);
  return tiles;
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

/// The map whose owners are owner_of(tile).
template <class OwnerOf>
TileMap map_by(const GridGeometry& grid, int n_ranks, OwnerOf owner_of) {
  std::vector<std::int32_t> owners;
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) owners.push_back(static_cast<std::int32_t>(owner_of(tile)));
  return {n_ranks, std::move(owners)};
}

/// Neighbouring tiles at ranks that have nothing to do with each other.
inline TileMap scattered_map(const GridGeometry& grid, int n_ranks) {
  return map_by(grid, n_ranks, [n_ranks](TileIndex tile) { return tile * 7919 % 101 % n_ranks; });
}

/// Every tile at one rank.
inline TileMap map_to(const GridGeometry& grid, int n_ranks, int owner) {
  return map_by(grid, n_ranks, [owner](TileIndex) { return owner; });
}

/// Every owner is one of the map's ranks.
inline void expect_owners_in_range(const TileMap& map) {
  for (TileIndex tile = 0; tile < map.n_tiles(); ++tile)
    ASSERT_TRUE(map.owner(tile) >= 0 && map.owner(tile) < map.n_ranks()) << map.owner(tile);
}

/// Load of each rank.
inline std::vector<GlobalIndex> rank_loads(const TileMap& map, const TileLoad& load) {
  std::vector<GlobalIndex> of_rank(static_cast<std::size_t>(map.n_ranks()), 0);
  for (std::size_t t = 0; t < load.size(); ++t) of_rank[static_cast<std::size_t>(map.owner(load.tile[t]))] += load.weight[t];
  return of_rank;
}

/// Largest over mean load of the ranks.
inline double uneven(const Partition& partition, const TileLoad& load) { return imbalance(rank_loads(partition.map, load)); }

inline int n_without_load(const Partition& partition, const TileLoad& load) {
  const std::vector<GlobalIndex> loads = rank_loads(partition.map, load);
  return static_cast<int>(std::count(loads.begin(), loads.end(), 0));
}

/// A load and its grid.
struct NamedLoad {
  const char* name;
  GridGeometry grid;
  TileLoad load;
};

inline std::vector<NamedLoad> loads_of_all_kinds() {
  std::vector<NamedLoad> result;
  for (const GridGeometry& grid : {grid_of_cells({44, 50, 37}), grid_of_cells({48, 40, 36}, {true, false, true}),
                                   grid_of_cells({120, 116, 4}, {true, true, true})}) {
    result.push_back({"random", grid, tile_load(random_load(grid, 5))});
    result.push_back({"ball", grid, tile_load(ball_load(grid))});
    result.push_back({"scattered", grid, tile_load(scattered_load(grid))});
  }
  for (NamedLoad& named : result)
    for (GlobalIndex& weight : named.load.weight) weight *= 80'000;  // ps, as a particle costs
  return result;
}

}  // namespace bulkley
