#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

#include "balance/diffusion.hpp"
#include "balance/graph_parts.hpp"
#include "balance/ranges.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::diffusion_test {
namespace {

using Parts = std::optional<std::vector<std::int32_t>>;

// --- graph of the tiles ------------------------------------------------------------------------------------------------

TEST(TileGraphTest, TilesTouchByFacesEdgesAndCornersAlsoAroundAnAxis) {
  GridGeometry grid = grid_of_cells({12, 12, 8}, {true, true, true});  // 3 x 3 x 2 tiles: all touch all
  const TileLoad all = tile_load(std::vector<GlobalIndex>(18, 1));
  const TileGraph graph = tile_graph(grid, all);
  for (std::int32_t t = 0; t < 18; ++t) EXPECT_EQ(graph.first[t + 1] - graph.first[t], 17);  // each once

  grid = grid_of_cells({28, 28, 28});
  std::vector<GlobalIndex> counts(static_cast<std::size_t>(grid.n_tiles()), 0);
  for (const Int3 tile : {Int3{3, 3, 3}, Int3{3, 3, 4}, Int3{3, 4, 4}, Int3{4, 4, 4}, Int3{6, 6, 6}})
    counts[grid.tile_index(tile)] = 1;
  const TileGraph few = tile_graph(grid, tile_load(counts));
  EXPECT_EQ(few.first, (std::vector<GlobalIndex>{0, 3, 6, 9, 12, 12}));
  EXPECT_EQ(std::vector<std::int32_t>(few.shared.begin(), few.shared.begin() + 3), (std::vector<std::int32_t>{32, 8, 2}));
  EXPECT_EQ(n_pieces(few, {0, 0, 0, 0, 0}), 2);
  EXPECT_EQ(n_pieces(few, {0, 1, 0, 1, 0}), 3);
}

// --- diffusion ---------------------------------------------------------------------------------------------------------

double uneven(const std::vector<std::int32_t>& part, const TileLoad& load, int n_parts) {
  std::vector<GlobalIndex> of_part(static_cast<std::size_t>(n_parts), 0);
  for (std::size_t t = 0; t < part.size(); ++t) of_part[part[t]] += load.weight[t];
  return imbalance(of_part);
}

int n_different(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
  int n = 0;
  for (std::size_t t = 0; t < a.size(); ++t) n += a[t] != b[t];
  return n;
}

TEST(Diffused, NeverMakesTheLargestLoadLarger) {
  std::mt19937 random(3);
  for (const NamedLoad& named : loads_of_all_kinds()) {
    const TileGraph graph = tile_graph(named.grid, named.load);
    for (const int n_parts : {2, 5, 24}) {
      std::vector<std::int32_t> start(named.load.size());
      for (std::size_t t = 0; t < start.size(); ++t)  // slabs of uneven thickness, and some tiles astray
        start[t] = random() % 50 == 0 ? random() % n_parts
                                      : n_parts - 1 - static_cast<int>(std::sqrt(t * n_parts * n_parts / start.size()));
      const std::vector<std::int32_t> part = diffused(graph, named.load, start, n_parts, 1.02);
      EXPECT_LE(uneven(part, named.load, n_parts), uneven(start, named.load, n_parts)) << named.name;
      for (int p = 0; p < n_parts; ++p) {
        EXPECT_TRUE(std::count(part.begin(), part.end(), p) > 0 || std::count(start.begin(), start.end(), p) == 0);
      }
      EXPECT_EQ(part, diffused(graph, named.load, start, n_parts, 1.02));
    }
  }
}

TEST(Diffused, EvensOutSlabsOfABall) {
  const GridGeometry grid = grid_of_cells({124, 124, 124});
  const TileLoad load = tile_load(ball_load(grid));
  const TileGraph graph = tile_graph(grid, load);
  for (const int n_parts : {4, 16}) {
    std::vector<std::int32_t> slab(load.size());
    const Int3 first = grid.tile_coordinates(load.tile.front()), last = grid.tile_coordinates(load.tile.back());
    for (std::size_t t = 0; t < slab.size(); ++t)
      slab[t] = (grid.tile_coordinates(load.tile[t])[0] - first[0]) * n_parts / (last[0] - first[0] + 1);
    ASSERT_GT(uneven(slab, load, n_parts), 1.4);
    EXPECT_LT(uneven(diffused(graph, load, slab, n_parts, 1.02), load, n_parts), 1.05);
  }
}

// Nodes that tiles on both sides of borders of parts have in common, summed over pairs of tiles.
GlobalIndex border(const TileGraph& graph, const std::vector<std::int32_t>& part) {
  GlobalIndex sum = 0;
  for (std::int32_t t = 0; t < graph.size(); ++t)
    for (std::int32_t e = graph.first[t]; e < graph.first[t + 1]; ++e)
      if (part[graph.neighbour[e]] != part[t]) sum += graph.shared[e] == 32 ? 32 : graph.shared[e] == 8 ? 16 : 8;
  return sum / 2;
}

// With a few tiles a part even loads are out of reach; flows that try for them shift every border.
TEST(Diffused, HardlyLengthensBordersOfPartsOfFewTiles) {
  const GridGeometry grid = grid_of_cells({124, 124, 124});
  TileLoad load = tile_load(ball_load(grid));
  for (std::size_t t = 0; t < load.size(); ++t) load.weight[t] = 100 + static_cast<GlobalIndex>(t) * 7919 % 413;
  const TileGraph graph = tile_graph(grid, load);
  for (const int n_parts : {100, 160}) {
    std::string fault;
    const Parts before = graph_parts(graph, load, n_parts, fault);
    ASSERT_TRUE(before) << fault;
    ASSERT_GT(uneven(*before, load, n_parts), 1.1);
    const std::vector<std::int32_t> after = diffused(graph, load, *before, n_parts, 1.02);
    EXPECT_LT(uneven(after, load, n_parts), uneven(*before, load, n_parts) - 0.03);
    EXPECT_LT(static_cast<double>(border(graph, after)), 1.01 * static_cast<double>(border(graph, *before)));
  }
}

TEST(Diffused, MovesFewTilesAfterASmallChange) {
  const GridGeometry grid = grid_of_cells({124, 124, 124});
  TileLoad load = tile_load(ball_load(grid));
  const TileGraph graph = tile_graph(grid, load);
  std::string fault;
  const Parts before = graph_parts(graph, load, 16, fault);
  ASSERT_TRUE(before) << fault;
  EXPECT_EQ(diffused(graph, load, *before, 16, 1.02), *before);  // even enough as it is
  for (std::size_t t = 0; t < load.size(); ++t)
    if ((*before)[t] == 5) load.weight[t] += load.weight[t] / 5;
  ASSERT_GT(uneven(*before, load, 16), 1.15);
  const std::vector<std::int32_t> after = diffused(graph, load, *before, 16, 1.02);
  EXPECT_LE(uneven(after, load, 16), 1.02);
  EXPECT_LT(n_different(*before, after), static_cast<int>(load.size()) / 20);
}

}  // namespace
}  // namespace bulkley::diffusion_test
