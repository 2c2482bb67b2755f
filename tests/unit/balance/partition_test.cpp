#include "balance/partition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "bulkley/base/error.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::partition_test {
namespace {

constexpr PartitionSettings uniform{PartitionMethod::uniform};
constexpr PartitionSettings ranges{PartitionMethod::ranges};

GridGeometry open_grid(const Int3& n_cells) { return grid_of_cells(n_cells); }

void expect_valid(const GridGeometry& grid, const Partition& partition, int n_ranks) {
  EXPECT_EQ(partition.map.n_ranks(), n_ranks);
  ASSERT_TRUE(partition.boxes);
  const Boxes& boxes = *partition.boxes;
  EXPECT_EQ(boxes.n_ranks[0] * boxes.n_ranks[1] * boxes.n_ranks[2], n_ranks);
  std::array<std::vector<int>, 3> process_of_tile;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<int>& nodes = boxes.nodes[axis];
    ASSERT_EQ(nodes.size(), static_cast<std::size_t>(boxes.n_ranks[axis]));
    EXPECT_EQ(std::accumulate(nodes.begin(), nodes.end(), 0), grid.n_nodes(axis));
    for (std::size_t p = 0; p < nodes.size(); ++p) {
      EXPECT_GT(nodes[p], 0);
      EXPECT_TRUE(nodes[p] % tile_width == 0 || p + 1 == nodes.size());
      process_of_tile[axis].insert(process_of_tile[axis].end(), (nodes[p] + tile_width - 1) / tile_width, p);
    }
    ASSERT_EQ(process_of_tile[axis].size(), static_cast<std::size_t>(grid.n_tiles(axis)));
  }
  ASSERT_EQ(partition.map.n_tiles(), grid.n_tiles());
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
    const Int3 at = grid.tile_coordinates(tile);
    ASSERT_EQ(partition.map.owner(tile),
              boxes.rank_of({process_of_tile[0][at[0]], process_of_tile[1][at[1]], process_of_tile[2][at[2]]}));
  }
}

GlobalIndex largest_load(const Partition& partition, const std::vector<GlobalIndex>& load) {
  const std::vector<GlobalIndex> of_rank = rank_loads(partition.map, tile_load(load));
  return *std::max_element(of_rank.begin(), of_rank.end());
}

TEST(Partition, CoversTheGridForAnyNumberOfRanks) {
  GridGeometry slab = open_grid({61, 40, 4});
  slab.periodic = {true, false, true};
  slab.n_cells[0] = 60;
  for (const GridGeometry& grid : {open_grid({30, 41, 23}), slab})
    for (const int n_ranks : {1, 2, 3, 4, 5, 7, 8, 12, 30})
      for (const PartitionSettings& settings : {uniform, ranges}) {
        SCOPED_TRACE(testing::Message() << n_ranks << " ranks, method " << static_cast<int>(settings.method));
        expect_valid(grid, make_partition(grid, settings, tile_load(random_load(grid, n_ranks)), n_ranks), n_ranks);
      }
}

TEST(Partition, RangesAreOptimalAlongOneAxis) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const GridGeometry grid = open_grid({36, 0, 0});  // 10 x 1 x 1 tiles
    ASSERT_EQ(grid.n_tiles(), 10);
    std::vector<GlobalIndex> load(10);
    for (GlobalIndex& tile : load) tile = 1000 * (random() % 10);  // large: the constant per tile decides nothing
    GlobalIndex optimum = std::accumulate(load.begin(), load.end(), GlobalIndex{0});
    for (int a = 1; a < 9; ++a)
      for (int b = a + 1; b < 10; ++b) {
        const auto sum = [&](int from, int to) {
          return std::accumulate(load.begin() + from, load.begin() + to, GlobalIndex{0});
        };
        optimum = std::min(optimum, std::max({sum(0, a), sum(a, b), sum(b, 10)}));
      }
    EXPECT_EQ(largest_load(make_partition(grid, ranges, tile_load(load), 3), load), optimum) << "trial " << trial;
  }
}

// Along several axes the cuts are improved one axis at a time, which need not end at the optimum; on average it is near.
TEST(Partition, RangesAreNearlyOptimalAlongTwoAxes) {
  const GridGeometry grid = open_grid({28, 28, 0});  // 8 x 8 x 1 tiles
  ASSERT_EQ(grid.n_tiles(), 64);
  double ratio_sum = 0.0;
  constexpr int n_trials = 100;
  for (int trial = 0; trial < n_trials; ++trial) {
    std::mt19937 random(trial);
    std::vector<GlobalIndex> load(64);
    for (GlobalIndex& tile : load) tile = random() % 3 == 0 ? 1000 * (random() % 50) : 0;
    const auto box = [&](int x0, int x1, int y0, int y1) {
      GlobalIndex sum = 0;
      for (int x = x0; x < x1; ++x)
        for (int y = y0; y < y1; ++y) sum += load[8 * x + y];
      return sum;
    };
    // Nine ranks fit only as 3 x 3: all pairs of two cuts.
    GlobalIndex optimum = box(0, 8, 0, 8);
    for (int a = 1; a < 7; ++a)
      for (int b = a + 1; b < 8; ++b)
        for (int c = 1; c < 7; ++c)
          for (int d = c + 1; d < 8; ++d) {
            GlobalIndex largest = 0;
            const std::array x{0, a, b, 8}, y{0, c, d, 8};
            for (int i = 0; i < 3; ++i)
              for (int k = 0; k < 3; ++k) largest = std::max(largest, box(x[i], x[i + 1], y[k], y[k + 1]));
            optimum = std::min(optimum, largest);
          }
    const GlobalIndex found = largest_load(make_partition(grid, ranges, tile_load(load), 9), load);
    EXPECT_GE(found, optimum);
    ratio_sum += static_cast<double>(found) / static_cast<double>(optimum);
  }
  EXPECT_LT(ratio_sum / n_trials, 1.05);
}

TEST(Partition, RangesBalanceABallBetterThanUniform) {
  const GridGeometry grid = open_grid({124, 124, 124});
  const std::vector<GlobalIndex> load = ball_load(grid);
  for (const int n_ranks : {2, 3, 4, 8, 16, 64}) {
    const double by_ranges = uneven(make_partition(grid, ranges, tile_load(load), n_ranks), tile_load(load));
    const double by_uniform = uneven(make_partition(grid, uniform, tile_load(load), n_ranks), tile_load(load));
    EXPECT_LT(by_ranges, 0.7 * by_uniform) << n_ranks << " ranks";
    EXPECT_LT(by_ranges, n_ranks <= 8 ? 1.15 : 1.4) << n_ranks << " ranks";
  }
}

TEST(Partition, UniformTakesTheLeastSurface) {
  const auto grid_of = [](const GridGeometry& grid, int n_ranks) {
    return make_partition(grid, uniform, tile_load(std::vector<GlobalIndex>(grid.n_tiles(), 0)), n_ranks).boxes->n_ranks;
  };
  EXPECT_EQ(grid_of(open_grid({60, 12, 12}), 4), (Int3{4, 1, 1}));
  EXPECT_EQ(grid_of(open_grid({28, 28, 28}), 8), (Int3{2, 2, 2}));
  // 64 slabs of one tile would be 3 % better balanced, with four times the surface.
  EXPECT_EQ(grid_of(open_grid({252, 248, 248}), 64), (Int3{4, 4, 4}));
}

TEST(Partition, EmptySpaceIsDividedToo) {
  const GridGeometry grid = open_grid({60, 60, 60});
  std::vector<GlobalIndex> load(grid.n_tiles(), 0);
  const std::vector<GlobalIndex> ones(grid.n_tiles(), 1);
  EXPECT_NEAR(uneven(make_partition(grid, ranges, tile_load(load), 8), tile_load(ones)), 1.0, 1e-12);
  load[0] = 5;  // one tile with all the particles: the others share the rest
  EXPECT_LT(uneven(make_partition(grid, ranges, tile_load(load), 8), tile_load(ones)), 2.5);
}

TEST(Partition, TheNodesBehindAndInFrontOfAFaceHaveOneOwner) {
  for (int n_cells = 5; n_cells <= 20; ++n_cells)
    for (const PartitionSettings& settings : {uniform, ranges}) {
      const GridGeometry grid = open_grid({n_cells, 4, 4});
      const Partition partition = make_partition(grid, settings, tile_load(random_load(grid, 7)), 2);
      if (partition.boxes->n_ranks[0] < 2) continue;
      const int n_first = partition.boxes->nodes[0][0];  // of the first of two owners
      EXPECT_GE(n_first, 3);
      EXPECT_FALSE(n_cells < n_first && n_first <= n_cells + 2) << n_cells;  // in front: n_cells; behind: n_cells + 2
    }
}

TEST(Partition, TooFewTiles) {
  const GridGeometry grid = open_grid({4, 4, 0});
  ASSERT_EQ(grid.n_tiles(), 4);
  const std::vector<GlobalIndex> load(4, 1);
  for (const int n_ranks : {3, 5, 8}) {
    try {
      make_partition(grid, ranges, tile_load(load), n_ranks);
      ADD_FAILURE() << n_ranks << " ranks were accepted";
    } catch (const UsageError& error) {
      const std::string expected =
          "the grid has 2 x 2 x 1 tiles of 4 nodes per axis, too few to give each of " + std::to_string(n_ranks) + " ranks";
      EXPECT_EQ(std::string(error.what()).substr(0, expected.size()), expected);
    }
  }
  EXPECT_NO_THROW(make_partition(grid, ranges, tile_load(load), 4));
}

TEST(Partition, BoxFaultPredictsWhetherThereAreBoxes) {
  for (const GridGeometry& grid :
       {open_grid({8, 8, 8}), open_grid({4, 4, 30}), grid_of_cells({12, 8, 4}, {true, true, true})})
    for (int n_ranks = 1; n_ranks <= 40; ++n_ranks) {
      const TileLoad load = tile_load(random_load(grid, 1));
      if (box_fault(grid, n_ranks).empty())
        expect_valid(grid, make_partition(grid, ranges, load, n_ranks), n_ranks);
      else
        EXPECT_THROW(make_partition(grid, ranges, load, n_ranks), UsageError) << n_ranks;
    }
}

TEST(Partition, ImbalanceIsLargestOverMean) {
  EXPECT_DOUBLE_EQ(imbalance({3, 6, 0}), 2.0);
  EXPECT_DOUBLE_EQ(imbalance({0, 0, 0}), 1.0);
  EXPECT_DOUBLE_EQ(imbalance({3, 3, 3}), 1.0);
}

TEST(Partition, CountsWhatAChangeOfMapsMoves) {
  const TileLoad load = tile_load(std::vector<GlobalIndex>{1, 2, 0, 4, 8});
  const TileMap from(4, {0, 0, 1, 2, 2}), to(4, {0, 1, 2, 0, 2});
  EXPECT_EQ(n_moved(from, to, load), 6);
  EXPECT_EQ(busiest_moves(from, to, load), 6);  // rank 0 sends 2 and receives 4
  EXPECT_EQ(n_moved(from, from, load), 0);
  EXPECT_EQ(busiest_moves(from, from, load), 0);
}

}  // namespace
}  // namespace bulkley::partition_test
