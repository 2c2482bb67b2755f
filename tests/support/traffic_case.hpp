#pragma once
// Maps and loads for which the traffic of ranks is predicted and counted.

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "balance/traffic.hpp"
#include "kernel/cells.hpp"
#include "support/tile_loads.hpp"

namespace bulkley {

/// Tiles with particles in some of their cells, and owners at random.
struct TrafficCase {
  GridGeometry grid;
  TileMap map;
  TileLoad load;

  TrafficCase(const GridGeometry& geometry, int n_ranks, unsigned seed) : grid(geometry) {
    std::mt19937_64 random(seed);
    load = tile_load(random_load(grid, seed));
    for (std::uint64_t& cells : load.cells) {
      cells = std::uint64_t{1} << random() % 64;
      if (random() % 2 == 0) cells |= random() & random();
    }
    for (std::size_t t = 0; t < load.size(); ++t) load.weight[t] = 3 * load.count[t] + 1;
    const auto n_owners = static_cast<unsigned>(seed < 2 && n_ranks > 1 ? n_ranks - 1 : n_ranks);  // not every rank has work
    map = map_by(grid, n_ranks, [&](TileIndex) { return random() % n_owners; });
  }

  std::vector<TileIndex> loaded_tiles(int rank) const {
    std::vector<TileIndex> tiles;
    for (const TileIndex tile : load.tile)
      if (map.owner(tile) == rank) tiles.push_back(tile);
    return tiles;
  }
  /// As Solver::rebuild makes it from the rank's own census.
  PoolLayout pool(int rank) const {
    TileCensus census;
    for (std::size_t t = 0; t < load.size(); ++t) {
      if (map.owner(load.tile[t]) != rank) continue;
      census.tile.push_back(load.tile[t]);
      census.cells.push_back(load.cells[t]);
    }
    std::vector<TileIndex> tiles = tiles_in_reach(grid, census);
    std::erase_if(tiles, [&](TileIndex tile) { return map.owner(tile) != rank; });
    return {grid, std::move(tiles)};
  }
  GlobalIndex sum(const std::vector<GlobalIndex>& values, int rank) const {
    GlobalIndex result = 0;
    for (std::size_t t = 0; t < load.size(); ++t)
      if (map.owner(load.tile[t]) == rank) result += values[t];
    return result;
  }
};

inline void for_each_case(int n_ranks, const std::function<void(const TrafficCase&)>& check) {
  const GridGeometry shapes[] = {grid_of_cells({9, 17, 13}), grid_of_cells({12, 16, 20}, {true, true, true}),
                                 grid_of_cells({27, 8, 14}, {false, true, false}),
                                 grid_of_cells({40, 4, 8}, {true, true, false}),
                                 grid_of_cells({40, 1, 18}, {false, true, false}),
                                 grid_of_cells({32, 24, 1}, {true, false, true})};
  for (GridGeometry grid : shapes)
    for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic})
      for (unsigned seed = 0; seed < 5; ++seed) {
        SCOPED_TRACE(testing::Message() << grid.n_cells[0] << " x " << grid.n_cells[1] << " x " << grid.n_cells[2]
                                        << " cells, order " << static_cast<int>(order) << ", seed " << seed);
        grid.order = order;
        check(TrafficCase(grid, n_ranks, seed));
      }
}

}  // namespace bulkley
