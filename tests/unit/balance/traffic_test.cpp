// The traffic that maps are predicted to cause, compared with counts of nodes one by one.
#include "balance/traffic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/traffic_case.hpp"

namespace bulkley::traffic_test {
namespace {

TEST(Traffic, NeighboursAreThoseWithCommonNodes) {
  for (const int n_ranks : {1, 2, 3, 4})
    for_each_case(n_ranks, [&](const TrafficCase& c) {
      const NodeOwner owner_of(c.grid, c.map);
      std::set<std::pair<int, int>> pairs;
      for (int rank = 0; rank < n_ranks; ++rank) {
        const PoolLayout pool = c.pool(rank);
        for (const NodeRow& row : pool.rows())
          for (int n = 0; n < row.count; ++n) {
            Int3 tile{row.i, row.j, row.k + n};
            bool exists = true;
            for (int axis = 0; axis < 3; ++axis) {
              if (c.grid.periodic[axis]) tile[axis] %= c.grid.n_nodes(axis);
              exists = exists && tile[axis] < c.grid.n_nodes(axis);
              tile[axis] /= tile_width;
            }
            if (!exists) continue;
            const int owner = owner_of(tile);
            if (owner == rank) continue;
            pairs.insert({rank, owner});
            pairs.insert({owner, rank});
          }
      }
      const std::vector<RankTraffic> traffic = predict_traffic(c.grid, c.map, c.load);
      for (int rank = 0; rank < n_ranks; ++rank)
        EXPECT_EQ(traffic[rank].n_neighbours,
                  std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) { return pair.first == rank; }));
    });
}

TEST(Traffic, CountsWorkAndHalo) {
  for (const int n_ranks : {1, 3, 6})
    for_each_case(n_ranks, [&](const TrafficCase& c) {
      const std::vector<RankTraffic> traffic = predict_traffic(c.grid, c.map, c.load);
      ASSERT_EQ(traffic.size(), static_cast<std::size_t>(n_ranks));
      for (int rank = 0; rank < n_ranks; ++rank) {
        const std::vector<TileIndex> tiles = c.loaded_tiles(rank);
        EXPECT_EQ(traffic[rank].load, c.sum(c.load.weight, rank));
        EXPECT_EQ(traffic[rank].n_particles, c.sum(c.load.count, rank));
        EXPECT_EQ(traffic[rank].n_worked_nodes, tile_nodes * static_cast<GlobalIndex>(tiles.size()));
        EXPECT_EQ(traffic[rank].n_worked_nodes + traffic[rank].n_halo_nodes, PoolLayout(c.grid, tiles).n_nodes());
      }
    });
}

TEST(Traffic, CountsWhatLeavesNodesOfConsecutiveRanks) {
  int n_between = 0;
  for_each_case(6, [&](const TrafficCase& c) {
    const auto off_node = [&](int ranks_per_node) {
      std::vector<GlobalIndex> bytes;
      for (const RankTraffic& rank : predict_traffic(c.grid, c.map, c.load, ranks_per_node))
        bytes.push_back(rank.bytes_off_node);
      return bytes;
    };
    std::vector<GlobalIndex> all, none(6, 0);
    for (const RankTraffic& rank : predict_traffic(c.grid, c.map, c.load)) all.push_back(rank.bytes_add + rank.bytes_get);
    EXPECT_EQ(off_node(0), none);
    EXPECT_EQ(off_node(6), none);
    EXPECT_EQ(off_node(1), all);
    // What one of two nodes sends as sums comes back as velocities.
    const std::vector<GlobalIndex> two = off_node(4);
    EXPECT_EQ(two[0] + two[1] + two[2] + two[3], two[4] + two[5]);
    for (std::size_t rank = 0; rank < 6; ++rank) EXPECT_LE(two[rank], all[rank]);
    for (std::size_t rank = 0; rank < 4; ++rank) n_between += two[rank] > 0 && two[rank] < all[rank];
  });
  EXPECT_GT(n_between, 0);
}

TEST(Traffic, TheSlowestRankIsTheStep) {
  CostModel cost;
  cost.byte = 3.0;
  cost.message = 1000.0;
  std::vector<RankTraffic> traffic(3);
  traffic[0].load = 5'000'000;  // ps
  traffic[1].load = 1'000'000;
  traffic[1].bytes_add = 100, traffic[1].bytes_get = 50;
  traffic[1].messages_add = 2, traffic[1].messages_get = 1;
  // 1000 ns, 2 * 150 bytes and 2 * 3 messages: what is sent one way comes back the other.
  EXPECT_DOUBLE_EQ(predicted_step(traffic, cost), 1e-9 * (1000.0 + 300 * 3.0 + 6 * 1000.0));
  EXPECT_DOUBLE_EQ(predicted_exchange(traffic, cost), 1e-9 * (300 * 3.0 + 6 * 1000.0));
  CostModel twice = cost;
  twice.n_exchanges = 2;
  EXPECT_DOUBLE_EQ(predicted_step(traffic, twice), 1e-9 * (1000.0 + 2 * (300 * 3.0 + 6 * 1000.0)));
  EXPECT_DOUBLE_EQ(predicted_exchange(traffic, twice), 2.0 * predicted_exchange(traffic, cost));
  traffic[0].load = 9'000'000;
  EXPECT_DOUBLE_EQ(predicted_step(traffic, cost), 9e-6);
}

}  // namespace
}  // namespace bulkley::traffic_test
