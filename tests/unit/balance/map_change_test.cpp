// When a change of maps saves more than it costs.
#include "balance/map_change.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "balance/traffic.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::map_change_test {
namespace {

class WorthwhileChange : public testing::Test {
 protected:
  static constexpr int n_ranks = 6;
  GridGeometry grid = grid_of_cells({60, 60, 60});
  TileLoad load = of_ball(0);
  Partition even = make_partition(grid, {PartitionMethod::metis}, load, n_ranks);
  ChangeCost change{1e-3, 1e-6, 1e-5};
  double exchange = predicted_exchange(predict_traffic(grid, even.map, load), {});

  // The ball, each tile heavier by `slope` parts in a thousand for every tile further along x.
  TileLoad of_ball(int slope) const {
    std::vector<GlobalIndex> weights = ball_load(grid);
    for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile)
      weights[tile] += weights[tile] * slope * grid.tile_coordinates(tile)[0] / 1000;
    TileLoad result = tile_load(weights);
    for (GlobalIndex& weight : result.weight) weight *= 80'000;  // ps
    return result;
  }
  double largest(const Partition& partition, const TileLoad& loads) const { return uneven(partition, loads); }
};

TEST_F(WorthwhileChange, NoneWhereLoadsAreEven) {
  EXPECT_LT(largest(even, load), 1.021);
  EXPECT_FALSE(worthwhile_change(grid, load, even, {}, change, 1e9, exchange).partition);
}

TEST_F(WorthwhileChange, OneWhereItPaysForLongEnough) {
  const TileLoad slanted = of_ball(100);
  const double before = largest(even, slanted);
  ASSERT_GT(before, 1.1);
  EXPECT_FALSE(worthwhile_change(grid, slanted, even, {}, change, 1.0, exchange).partition);
  const Change found = worthwhile_change(grid, slanted, even, {}, change, 1000.0, exchange);
  ASSERT_TRUE(found.partition);
  EXPECT_LT(largest(*found.partition, slanted), 1.05);
  // It moves little more than the surplus.
  EXPECT_LT(static_cast<double>(n_moved(even.map, found.partition->map, slanted)),
            0.25 * static_cast<double>(std::accumulate(slanted.count.begin(), slanted.count.end(), GlobalIndex{0})));
}

TEST_F(WorthwhileChange, TheMoreExpensiveTheChangeTheLongerItTakesToPay) {
  const TileLoad slanted = of_ball(100);
  const auto shortest_horizon = [&](const ChangeCost& price) {
    double horizon = 1.0;
    while (horizon < 1e12 && !worthwhile_change(grid, slanted, even, {}, price, horizon, exchange).partition) horizon *= 2.0;
    return horizon;
  };
  const double usual = shortest_horizon(change);
  ChangeCost slow_rebuild = change, slow_moves = change;
  slow_rebuild.rebuild *= 100.0;
  slow_moves.particle *= 1000.0;
  EXPECT_GT(shortest_horizon(slow_rebuild), usual);
  EXPECT_GT(shortest_horizon(slow_moves), usual);
  EXPECT_LT(usual, 1e6);
}

TEST_F(WorthwhileChange, AWholeNewMapWhereBordersHaveGrownTooLong) {
  // Every other tile of two halves changed places: even loads, but nearly all nodes are shared.
  Partition tattered = even;
  tattered.map = scattered_map(grid, n_ranks);
  CostModel slow_network;
  slow_network.byte = 5.0;
  const double fresh = predicted_exchange(predict_traffic(grid, even.map, load), slow_network);
  const Change found = worthwhile_change(grid, load, tattered, slow_network, change, 1e5, fresh);
  ASSERT_TRUE(found.partition);
  EXPECT_TRUE(found.whole);
  EXPECT_LT(predicted_exchange(predict_traffic(grid, found.partition->map, load), slow_network), 1.5 * fresh);
}

// With fewer tiles than ranks the mean is out of reach: no whole new map is made in the hope of it.
TEST_F(WorthwhileChange, NoneIsSoughtWhereEveryTileHasItsRank) {
  const GridGeometry small = grid_of_cells({8, 8, 8});
  TileLoad tiles = tile_load(std::vector<GlobalIndex>(27, 300));
  for (GlobalIndex& weight : tiles.weight) weight *= 80'000;  // ps
  const Partition each = make_partition(small, {PartitionMethod::automatic}, tiles, 40);
  const double fresh = predicted_exchange(predict_traffic(small, each.map, tiles), {});
  const Change found = worthwhile_change(small, tiles, each, {}, change, 1e9, fresh);
  EXPECT_FALSE(found.partition);
  EXPECT_EQ(found.making, 0.0);
  Partition crowded = each;
  crowded.map = map_to(small, 40, 39);
  EXPECT_TRUE(worthwhile_change(small, tiles, crowded, {}, change, 1e9, fresh).partition);
}

TEST_F(WorthwhileChange, NoneWithoutParticles) {
  EXPECT_FALSE(worthwhile_change(grid, TileLoad{}, even, {}, change, 1e9, 0.0).partition);
}

TEST(WorthwhileChangeOnNodes, AWholeNewMapIsCutBetweenNodesFirst) {
  const GridGeometry grid = grid_of_cells({124, 124, 124});
  TileLoad load = tile_load(ball_load(grid));
  for (GlobalIndex& weight : load.weight) weight *= 80'000;  // ps
  constexpr int n_ranks = 60, ranks_per_node = 12;
  const Partition present{scattered_map(grid, n_ranks), {}};
  const Change found = worthwhile_change(grid, load, present, {}, {}, 1e9, 0.0, ranks_per_node);
  ASSERT_TRUE(found.partition && found.whole);
  ASSERT_NE(found.partition->map.tree(), nullptr) << "another method was faster: nothing is told";
  EXPECT_EQ(found.partition->map.tree()->halves(), RankHalves{ranks_per_node});
}

}  // namespace
}  // namespace bulkley::map_change_test
