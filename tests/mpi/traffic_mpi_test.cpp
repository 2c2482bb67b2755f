// ranks: 1 2 3 4
#include "balance/traffic.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <random>
#include <set>

#include "distribution/exchange.hpp"
#include "kernel/cells.hpp"
#include "support/tile_loads.hpp"

namespace bulkley {
namespace {

// Tiles with particles in some of their cells, and workers at random.
struct Case {
  GridGeometry grid;
  Partition partition;
  TileLoad load;

  Case(const GridGeometry& geometry, int n_ranks, unsigned seed) : grid(geometry) {
    std::mt19937_64 random(seed);
    load = tile_load(random_load(grid, seed));
    for (std::uint64_t& cells : load.cells) {
      cells = std::uint64_t{1} << random() % 64;
      if (random() % 2 == 0) cells |= random() & random();
    }
    for (std::size_t t = 0; t < load.size(); ++t) load.weight[t] = 3 * load.count[t] + 1;
    partition = make_partition(grid, {PartitionMethod::ranges}, load, n_ranks);
    for (std::int32_t& worker : partition.worker)  // the first seeds: not every rank has work
      worker = static_cast<std::int32_t>(random() % static_cast<unsigned>(seed < 2 && n_ranks > 1 ? n_ranks - 1 : n_ranks));
  }

  std::vector<TileIndex> loaded_tiles(int rank) const {
    std::vector<TileIndex> tiles;
    for (const TileIndex tile : load.tile)
      if (partition.worker[tile] == rank) tiles.push_back(tile);
    return tiles;
  }
  // As Solver::rebuild makes it from the rank's own census.
  PoolLayout pool(int rank) const {
    TileCensus census;
    for (std::size_t t = 0; t < load.size(); ++t) {
      if (partition.worker[load.tile[t]] != rank) continue;
      census.tile.push_back(load.tile[t]);
      census.cells.push_back(load.cells[t]);
    }
    std::vector<TileIndex> tiles = tiles_in_reach(grid, census);
    std::erase_if(tiles, [&](TileIndex tile) { return partition.worker[tile] != rank; });
    return {grid, std::move(tiles)};
  }
  GlobalIndex sum(const std::vector<GlobalIndex>& values, int rank) const {
    GlobalIndex result = 0;
    for (std::size_t t = 0; t < load.size(); ++t)
      if (partition.worker[load.tile[t]] == rank) result += values[t];
    return result;
  }
};

void for_each_case(int n_ranks, const std::function<void(const Case&)>& check) {
  const GridGeometry shapes[] = {grid_of_cells({9, 17, 13}), grid_of_cells({12, 16, 20}, {true, true, true}),
                                 grid_of_cells({27, 8, 14}, {false, true, false}),
                                 grid_of_cells({40, 4, 8}, {true, true, false})};
  for (GridGeometry grid : shapes)
    for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic})
      for (unsigned seed = 0; seed < 5; ++seed) {
        SCOPED_TRACE(testing::Message() << grid.n_cells[0] << " x " << grid.n_cells[1] << " x " << grid.n_cells[2]
                                        << " cells, order " << static_cast<int>(order) << ", seed " << seed);
        grid.order = order;
        check(Case(grid, n_ranks, seed));
      }
}

TEST(Traffic, IsThatOfTheExchange) {
  const Comm comm(PETSC_COMM_WORLD);
  GlobalIndex n_messages = 0;
  for_each_case(comm.size(), [&](const Case& c) {
    const PoolLayout pool = c.pool(comm.rank());
    const Exchange exchange(comm, c.grid, c.partition.worker, pool);
    const RankTraffic mine = predict_traffic(c.grid, c.partition, c.load)[comm.rank()];
    EXPECT_EQ(mine.n_tiles, static_cast<GlobalIndex>(pool.tiles().size()));
    EXPECT_EQ(mine.n_pool_nodes, pool.n_nodes());
    EXPECT_EQ(mine.bytes_add, static_cast<GlobalIndex>(exchange.sent_by_add().bytes));
    EXPECT_EQ(mine.bytes_get, static_cast<GlobalIndex>(exchange.sent_by_get().bytes));
    EXPECT_EQ(mine.messages_add, exchange.sent_by_add().n_messages);
    EXPECT_EQ(mine.messages_get, exchange.sent_by_get().n_messages);
    n_messages += mine.messages_add;
  });
  if (comm.size() > 1) {
    EXPECT_GT(sum_global(comm, n_messages), 0);
  }
}

TEST(Traffic, NeighboursAreThoseWithCommonNodes) {
  const Comm comm(PETSC_COMM_WORLD);
  for_each_case(comm.size(), [&](const Case& c) {
    const NodeOwner owner_of(c.grid, c.partition.worker);
    std::set<std::pair<int, int>> pairs;
    for (int rank = 0; rank < comm.size(); ++rank) {
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
    const std::vector<RankTraffic> traffic = predict_traffic(c.grid, c.partition, c.load);
    for (int rank = 0; rank < comm.size(); ++rank)
      EXPECT_EQ(traffic[rank].n_neighbours,
                std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) { return pair.first == rank; }));
  });
}

TEST(Traffic, CountsWorkAndHalo) {
  for (const int n_ranks : {1, 3, 6})
    for_each_case(n_ranks, [&](const Case& c) {
      const std::vector<RankTraffic> traffic = predict_traffic(c.grid, c.partition, c.load);
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
}  // namespace bulkley
