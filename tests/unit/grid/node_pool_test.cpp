#include "grid/node_pool.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace bulkley::node_pool_test {
namespace {

GridGeometry grid_of_tiles(const Int3& n_tiles, SplineOrder order, bool periodic = false) {
  GridGeometry grid;
  grid.cell_size = 0.1;
  grid.order = order;
  for (int axis = 0; axis < 3; ++axis) {
    grid.periodic[axis] = periodic;
    grid.n_cells[axis] = n_tiles[axis] * tile_width - (periodic ? 0 : 4);
  }
  return grid;
}

std::vector<TileIndex> random_tiles(const GridGeometry& grid, double fraction, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution chosen(fraction);
  std::vector<TileIndex> tiles;
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile)
    if (chosen(random)) tiles.push_back(tile);
  return tiles;
}

// Truth: every footprint node of every tile, as the set of its grid indices.
std::set<Int3> nodes_reached(const GridGeometry& grid, const std::vector<TileIndex>& tiles) {
  const int width = footprint_width(grid.order);
  std::set<Int3> nodes;
  for (TileIndex tile : tiles) {
    const Int3 at = grid.tile_coordinates(tile);
    for (int i = 0; i < width; ++i)
      for (int j = 0; j < width; ++j)
        for (int k = 0; k < width; ++k)
          nodes.insert({at[0] * tile_width + i, at[1] * tile_width + j, at[2] * tile_width + k});
  }
  return nodes;
}

void expect_one_to_one(const GridGeometry& grid, const std::vector<TileIndex>& tiles) {
  const PoolLayout pool(grid, tiles);
  const std::set<Int3> truth = nodes_reached(grid, tiles);
  ASSERT_EQ(pool.n_nodes(), static_cast<LocalIndex>(truth.size()));

  // Rows name each node once, at consecutive pool indices.
  std::vector<Int3> node_at(truth.size(), Int3{-1, -1, -1});
  LocalIndex next = 0;
  for (const NodeRow& row : pool.rows()) {
    ASSERT_EQ(row.offset, next);
    ASSERT_GT(row.count, 0);
    for (int n = 0; n < row.count; ++n) node_at[next++] = {row.i, row.j, row.k + n};
  }
  ASSERT_EQ(next, pool.n_nodes());
  EXPECT_EQ(std::set<Int3>(node_at.begin(), node_at.end()), truth);

  // The table of each tile leads to the same nodes.
  const int width = footprint_width(grid.order);
  ASSERT_EQ(pool.row_offsets().size(), tiles.size() * width * width);
  for (std::size_t slot = 0; slot < tiles.size(); ++slot) {
    ASSERT_EQ(pool.slot(tiles[slot]), static_cast<LocalIndex>(slot));
    const Int3 at = grid.tile_coordinates(tiles[slot]);
    for (int i = 0; i < width; ++i)
      for (int j = 0; j < width; ++j) {
        const LocalIndex offset = pool.row_offsets()[(slot * width + i) * width + j];
        ASSERT_TRUE(offset >= 0 && offset + width <= pool.n_nodes());
        for (int k = 0; k < width; ++k) {
          const Int3 expected{at[0] * tile_width + i, at[1] * tile_width + j, at[2] * tile_width + k};
          ASSERT_EQ(node_at[offset + k], expected)
              << "tile " << tiles[slot] << " footprint node " << i << ' ' << j << ' ' << k;
        }
      }
  }
}

class PoolOrders : public testing::TestWithParam<SplineOrder> {};
INSTANTIATE_TEST_SUITE_P(Pool, PoolOrders, testing::Values(SplineOrder::quadratic, SplineOrder::cubic));

TEST_P(PoolOrders, FullBoxMapsEachNodeOnce) {
  const GridGeometry grid = grid_of_tiles({3, 4, 5}, GetParam());
  std::vector<TileIndex> tiles(grid.n_tiles());
  std::iota(tiles.begin(), tiles.end(), 0);
  expect_one_to_one(grid, tiles);
}

TEST_P(PoolOrders, RandomTilesMapEachNodeOnce) {
  const GridGeometry grid = grid_of_tiles({6, 5, 7}, GetParam());
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    expect_one_to_one(grid, random_tiles(grid, 0.05 + 0.045 * seed, seed));
  }
}

TEST_P(PoolOrders, PeriodicFootprintsAreNotWrapped) {
  const GridGeometry grid = grid_of_tiles({2, 1, 3}, GetParam(), true);
  std::vector<TileIndex> tiles(grid.n_tiles());
  std::iota(tiles.begin(), tiles.end(), 0);
  expect_one_to_one(grid, tiles);
  const PoolLayout pool(grid, tiles);
  const int beyond = footprint_width(GetParam()) - tile_width;
  EXPECT_EQ(pool.n_nodes(), (8 + beyond) * (4 + beyond) * (12 + beyond));
}

TEST_P(PoolOrders, ScatteredTilesCostOnlyTheirOwnNodes) {
  const GridGeometry grid = grid_of_tiles({200, 200, 200}, GetParam());
  const std::vector<TileIndex> tiles{grid.tile_index({0, 0, 0}), grid.tile_index({0, 0, 199}), grid.tile_index({100, 3, 50}),
                                     grid.tile_index({199, 199, 199})};
  const int width = footprint_width(GetParam());
  EXPECT_EQ(PoolLayout(grid, tiles).n_nodes(), 4 * width * width * width);
}

TEST(Pool, OneRowForAColumnOfNeighbours) {
  const GridGeometry grid = grid_of_tiles({3, 3, 8}, SplineOrder::quadratic);
  const std::vector<TileIndex> tiles{grid.tile_index({1, 1, 2}), grid.tile_index({1, 1, 3}), grid.tile_index({1, 1, 6})};
  const PoolLayout pool(grid, tiles);
  ASSERT_EQ(pool.rows().size(), 2u * 36u);
  EXPECT_EQ(pool.rows()[0].k, 8);
  EXPECT_EQ(pool.rows()[0].count, 10);
  EXPECT_EQ(pool.rows()[1].k, 24);
  EXPECT_EQ(pool.rows()[1].count, 6);
}

TEST(Pool, SlotOfATileThatIsNotThere) {
  const GridGeometry grid = grid_of_tiles({2, 2, 2}, SplineOrder::quadratic);
  const PoolLayout pool(grid, {2, 5});
  EXPECT_EQ(pool.slot(0), -1);
  EXPECT_EQ(pool.slot(2), 0);
  EXPECT_EQ(pool.slot(3), -1);
  EXPECT_EQ(pool.slot(5), 1);
  EXPECT_EQ(pool.slot(7), -1);
}

// Compact sets, sets in two pieces at opposite corners of a large grid, and strides that all tiles share.
TEST(Pool, SlotsAreThoseOfASearchThroughTheTiles) {
  const GridGeometry grid = grid_of_tiles({512, 256, 256}, SplineOrder::quadratic);
  std::mt19937 random(4);
  for (int n_tiles : {1, 2, 3, 64, 1000, 4096})
    for (int kind = 0; kind < 4; ++kind) {
      std::set<TileIndex> chosen;
      while (static_cast<int>(chosen.size()) < n_tiles) {
        const auto n = static_cast<TileIndex>(random() % (3 * static_cast<unsigned>(n_tiles)));
        chosen.insert(kind == 0   ? n
                      : kind == 1 ? n % 2 == 0 ? n : grid.n_tiles() - n
                      : kind == 2 ? n * 256 % grid.n_tiles()
                                  : static_cast<TileIndex>(random() % static_cast<unsigned>(grid.n_tiles())));
      }
      const std::vector<TileIndex> tiles(chosen.begin(), chosen.end());
      const SlotTable table(tiles);
      EXPECT_LE(table.memory(), 32 * tiles.size());
      for (std::size_t t = 0; t < tiles.size(); ++t) {
        ASSERT_EQ(table.slot(tiles[t]), static_cast<LocalIndex>(t));
        for (const TileIndex other : {tiles[t] - 1, tiles[t] + 1, static_cast<TileIndex>(random() % 33554432u)})
          if (chosen.count(other) == 0) {
            ASSERT_EQ(table.slot(other), -1);
          }
      }
    }
}

TEST(Pool, NoTiles) {
  const PoolLayout pool(grid_of_tiles({2, 2, 2}, SplineOrder::quadratic), {});
  EXPECT_EQ(pool.n_nodes(), 0);
  EXPECT_TRUE(pool.rows().empty());
  EXPECT_TRUE(pool.row_offsets().empty());
  EXPECT_EQ(pool.slot(0), -1);
}

}  // namespace
}  // namespace bulkley::node_pool_test
