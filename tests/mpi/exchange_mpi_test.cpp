// ranks: 1 2 3 4 8
#include "distribution/exchange.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <span>

#include "support/tile_loads.hpp"

namespace bulkley::exchange_mpi_test {
namespace {

const GridShape shapes[] = {
    {"open", {9, 7, 13}, {false, false, false}},  // the last tiles reach beyond the last nodes
    {"periodic", {12, 8, 8}, {true, true, true}},
    {"plane across y", {20, 1, 13}, {false, true, false}},
    {"plane across z", {12, 18, 1}, {true, false, true}},
    {"slab of one tile", {14, 16, 4}, {false, true, true}},
    {"one tile along two axes", {40, 4, 4}, {true, true, true}},
};

// Which rank's pool a tile is in; -1: none.
struct Map {
  const char* name;
  std::function<int(TileIndex, const TileMap&, int n_ranks)> rank;
};
const Map maps[] = {
    {"owners", [](TileIndex tile, const TileMap& map, int) { return map.owner(tile); }},
    {"scattered", [](TileIndex tile, const TileMap&, int n_ranks) { return tile * 7919 % 101 % n_ranks; }},
    {"all on the last rank", [](TileIndex, const TileMap&, int n_ranks) { return n_ranks - 1; }},
    {"every third tile", [](TileIndex tile, const TileMap& map, int) { return tile % 3 == 0 ? map.owner(tile) : -1; }},
    {"no tiles", [](TileIndex, const TileMap&, int) { return -1; }},
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// What `rank` contributes to component c of a pool node; small integers, so that all sums are exact.
double contribution(int rank, const NodeRow& row, int n, int c) {
  return (rank + 1) * 1000 + (row.i * 31 + row.j * 17 + (row.k + n) * 7) % 997 + 10000 * c;
}

// One geometry, its owners and the pools of ranks, with the sums that every rank can compute for itself.
struct Setting {
  GridGeometry geometry;
  Partition partition;
  std::vector<PoolLayout> layouts;  // of each rank

  Setting(const GridShape& shape, SplineOrder order, const Map& map, int n_ranks) {
    geometry.cell_size = 0.1;
    geometry.n_cells = shape.n_cells;
    geometry.periodic = shape.periodic;
    geometry.order = order;
    partition = make_partition(geometry, {PartitionMethod::ranges},
                               tile_load(std::vector<GlobalIndex>(geometry.n_tiles(), 1)), n_ranks);
    std::vector<std::vector<TileIndex>> tiles(n_ranks);
    for (TileIndex tile = 0; tile < geometry.n_tiles(); ++tile) {
      const int rank = map.rank(tile, partition.map, n_ranks);
      if (rank >= 0) tiles[rank].push_back(tile);
    }
    for (auto& list : tiles) layouts.emplace_back(geometry, std::move(list));
  }

  // Position of a node in a dense array of the grid, wrapped where periodic; -1 beyond the grid.
  int dense(int i, int j, int k) const {
    Int3 node{i, j, k};
    for (int axis = 0; axis < 3; ++axis) {
      const int n = geometry.n_nodes(axis);
      if (geometry.periodic[axis] && n == 1 && node[axis] >= stencil_width(geometry.order)) return -1;  // no stencil gets there
      if (geometry.periodic[axis]) node[axis] %= n;
      if (node[axis] >= n) return -1;
    }
    return (node[0] * geometry.n_nodes(1) + node[1]) * geometry.n_nodes(2) + node[2];
  }
  // Rank whose box holds a node: here it owns their tiles.
  int owner(Int3 node) const {
    for (int axis = 0; axis < 3; ++axis)
      if (geometry.periodic[axis]) node[axis] %= geometry.n_nodes(axis);
    return partition.map.owner(geometry.tile_of_node(node));
  }
  std::size_t n_dense() const {
    return static_cast<std::size_t>(geometry.n_nodes(0)) * geometry.n_nodes(1) * geometry.n_nodes(2);
  }

  struct Truth {
    std::vector<Node> sums;
    std::vector<int> n_copies;  // pool nodes of all ranks that are this node
  };
  Truth truth() const {
    Truth result{std::vector<Node>(n_dense(), Node{}), std::vector<int>(n_dense(), 0)};
    for (std::size_t rank = 0; rank < layouts.size(); ++rank)
      for (const NodeRow& row : layouts[rank].rows())
        for (int n = 0; n < row.count; ++n) {
          const int at = dense(row.i, row.j, row.k + n);
          if (at < 0) continue;
          ++result.n_copies[at];
          for (int c = 0; c < 4; ++c) result.sums[at].c[c] += contribution(static_cast<int>(rank), row, n, c);
        }
    return result;
  }
};

class ExchangeTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  void for_each_setting(const std::function<void(const Setting&)>& check) {
    for (const GridShape& shape : shapes)
      for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic})
        for (const Map& map : maps) {
          SCOPED_TRACE(testing::Message() << shape.name << ", order " << static_cast<int>(order) << ", " << map.name);
          check(Setting(shape, order, map, comm.size()));
        }
  }
};

TEST_F(ExchangeTest, AddSumsAllCopiesOfEachNode) {
  for_each_setting([&](const Setting& setting) {
    const PoolLayout& layout = setting.layouts[comm.rank()];
    Exchange exchange(comm, setting.geometry, setting.partition.map, layout);

    std::vector<Node> pool(layout.n_nodes());
    for (const NodeRow& row : layout.rows())
      for (int n = 0; n < row.count; ++n) {
        const bool inside = setting.dense(row.i, row.j, row.k + n) >= 0;
        for (int c = 0; c < 4; ++c)
          pool[row.offset + n].c[c] = inside ? contribution(comm.rank(), row, n, c) : nan;  // beyond: takes no part
      }
    std::vector<Node> owned(exchange.n_owned(), Node{{1.0, 2.0, 3.0, 4.0}});  // what was there does not count
    exchange.add(pool.data(), owned.data());

    const Setting::Truth truth = setting.truth();
    const std::vector<Int3> positions = exchange.active_positions();
    ASSERT_EQ(positions.size(), exchange.active_nodes().size());
    int n_wrong = 0;
    std::vector<bool> found(setting.n_dense(), false);
    for (std::size_t a = 0; a < positions.size(); ++a) {
      const LocalIndex n = exchange.active_nodes()[a];
      const int at = setting.dense(positions[a][0], positions[a][1], positions[a][2]);
      ASSERT_GE(at, 0);
      for (int c = 0; c < 4; ++c) n_wrong += owned[n].c[c] != truth.sums[at].c[c];
      n_wrong += setting.owner(positions[a]) != comm.rank() || found[at];
      found[at] = true;
      owned[n] = Node{{1.0, 2.0, 3.0, 4.0}};
    }
    for (const Node& node : owned)  // nothing else was touched
      for (int c = 0; c < 4; ++c) n_wrong += node.c[c] != c + 1.0;
    EXPECT_EQ(n_wrong, 0);
    for (int i = 0; i < setting.geometry.n_nodes(0); ++i)
      for (int j = 0; j < setting.geometry.n_nodes(1); ++j)
        for (int k = 0; k < setting.geometry.n_nodes(2); ++k) {
          const int at = setting.dense(i, j, k);
          ASSERT_EQ(found[at], truth.n_copies[at] > 0 && setting.owner({i, j, k}) == comm.rank());
        }
  });
}

TEST_F(ExchangeTest, GetBringsTheOwnersValues) {
  for_each_setting([&](const Setting& setting) {
    const PoolLayout& layout = setting.layouts[comm.rank()];
    Exchange exchange(comm, setting.geometry, setting.partition.map, layout);

    std::vector<Node> owned(exchange.n_owned(), Node{{nan, nan, nan, nan}});
    const std::vector<Int3> positions = exchange.active_positions();
    for (std::size_t a = 0; a < positions.size(); ++a)
      for (int c = 0; c < 4; ++c)
        owned[exchange.active_nodes()[a]].c[c] = 4 * setting.dense(positions[a][0], positions[a][1], positions[a][2]) + c;
    std::vector<Node> pool(layout.n_nodes(), Node{{nan, nan, nan, nan}});
    exchange.get(owned.data(), pool.data());

    int n_wrong = 0;
    for (const NodeRow& row : layout.rows())
      for (int n = 0; n < row.count; ++n) {
        const int at = setting.dense(row.i, row.j, row.k + n);
        for (int c = 0; c < 4; ++c) n_wrong += pool[row.offset + n].c[c] != (at < 0 ? 0 : 4 * at + c);
      }
    EXPECT_EQ(n_wrong, 0);
  });
}

TEST_F(ExchangeTest, ASumIsNeverNegativeZero) {
  for_each_setting([&](const Setting& setting) {
    const PoolLayout& layout = setting.layouts[comm.rank()];
    Exchange exchange(comm, setting.geometry, setting.partition.map, layout);
    const std::vector<Node> pool(layout.n_nodes(), Node{{-0.0, -0.0, -0.0, -0.0}});
    std::vector<Node> owned(exchange.n_owned(), Node{{nan, nan, nan, nan}});
    exchange.add(pool.data(), owned.data());
    int n_wrong = 0;
    for (const LocalIndex n : exchange.active_nodes())
      for (const double value : owned[n].c) n_wrong += !(value == 0.0) || std::signbit(value);
    EXPECT_EQ(n_wrong, 0);
  });
}

TEST_F(ExchangeTest, CountsWhatGoesToOthers) {
  for_each_setting([&](const Setting& setting) {
    const Exchange exchange(comm, setting.geometry, setting.partition.map, setting.layouts[comm.rank()]);
    std::vector<std::size_t> to_owner(comm.size(), 0), to_sharer(comm.size(), 0);  // bytes of one add, one get
    for (int rank = 0; rank < comm.size(); ++rank)
      for (const NodeRow& row : setting.layouts[rank].rows())
        for (int n = 0; n < row.count; ++n) {
          if (setting.dense(row.i, row.j, row.k + n) < 0) continue;
          const int owner = setting.owner({row.i, row.j, row.k + n});
          if (owner == rank) continue;
          if (rank == comm.rank()) to_owner[owner] += 4 * sizeof(double);
          if (owner == comm.rank()) to_sharer[rank] += 4 * sizeof(double);
        }
    const auto expect = [](const std::vector<std::size_t>& bytes, const Exchange::Traffic& sent) {
      EXPECT_EQ(sent.bytes, std::accumulate(bytes.begin(), bytes.end(), std::size_t{0}));
      EXPECT_EQ(sent.n_messages, std::count_if(bytes.begin(), bytes.end(), [](std::size_t b) { return b > 0; }));
    };
    expect(to_owner, exchange.sent_by_add());
    expect(to_sharer, exchange.sent_by_get());
  });
}

TEST_F(ExchangeTest, PairsGoTheWaysOfTheirHalves) {
  for_each_setting([&](const Setting& setting) {
    const PoolLayout& layout = setting.layouts[comm.rank()];
    Exchange exchange(comm, setting.geometry, setting.partition.map, layout);
    std::vector<NodePair> pairs(layout.n_nodes());
    std::vector<Node> motion(layout.n_nodes()), change(layout.n_nodes());
    for (const NodeRow& row : layout.rows())
      for (int n = 0; n < row.count; ++n) {
        const bool inside = setting.dense(row.i, row.j, row.k + n) >= 0;
        for (int c = 0; c < 4; ++c) {
          motion[row.offset + n].c[c] = inside ? contribution(comm.rank(), row, n, c) : nan;
          change[row.offset + n].c[c] = inside ? -contribution(comm.rank() + 3, row, n, 3 - c) : nan;
        }
        pairs[row.offset + n] = {motion[row.offset + n], change[row.offset + n]};
      }
    const Node unset{{1.0, 2.0, 3.0, 4.0}};
    std::vector<Node> sums[2], expected[2];
    for (int half = 0; half < 2; ++half) sums[half] = expected[half] = std::vector<Node>(exchange.n_owned(), unset);
    exchange.add(motion.data(), expected[0].data());
    exchange.add(change.data(), expected[1].data());
    exchange.add(pairs.data(), sums[0].data(), sums[1].data());
    int n_wrong = 0;
    for (int half = 0; half < 2; ++half)
      n_wrong += !std::ranges::equal(std::as_bytes(std::span(sums[half])), std::as_bytes(std::span(expected[half])));
    EXPECT_EQ(n_wrong, 0);

    exchange.get(sums[0].data(), motion.data());
    exchange.get(sums[1].data(), change.data());
    exchange.get(sums[0].data(), sums[1].data(), pairs.data());
    for (std::size_t n = 0; n < pairs.size(); ++n)
      n_wrong += std::memcmp(&pairs[n].motion, &motion[n], sizeof(Node)) != 0 ||
                 std::memcmp(&pairs[n].change, &change[n], sizeof(Node)) != 0;
    EXPECT_EQ(n_wrong, 0);
  });
}

// Pools of one number a node: component 2 of those above.
TEST_F(ExchangeTest, ScalarsGoTheSameWays) {
  for_each_setting([&](const Setting& setting) {
    const PoolLayout& layout = setting.layouts[comm.rank()];
    Exchange exchange(comm, setting.geometry, setting.partition.map, layout);
    std::vector<double> pool(layout.n_nodes(), nan);
    for (const NodeRow& row : layout.rows())
      for (int n = 0; n < row.count; ++n)
        if (setting.dense(row.i, row.j, row.k + n) >= 0) pool[row.offset + n] = contribution(comm.rank(), row, n, 2);
    std::vector<double> owned(exchange.n_owned(), nan);
    exchange.add(pool.data(), owned.data());
    const Setting::Truth truth = setting.truth();
    const std::vector<Int3> positions = exchange.active_positions();
    int n_wrong = 0;
    for (std::size_t a = 0; a < positions.size(); ++a) {
      const int at = setting.dense(positions[a][0], positions[a][1], positions[a][2]);
      n_wrong += owned[exchange.active_nodes()[a]] != truth.sums[at].c[2];
    }
    std::fill(pool.begin(), pool.end(), nan);
    exchange.get(owned.data(), pool.data());
    for (const NodeRow& row : layout.rows())
      for (int n = 0; n < row.count; ++n) {
        const int at = setting.dense(row.i, row.j, row.k + n);
        n_wrong += pool[row.offset + n] != (at < 0 ? 0.0 : truth.sums[at].c[2]);
      }
    EXPECT_EQ(n_wrong, 0);

    std::fill(pool.begin(), pool.end(), -0.0);
    exchange.add(pool.data(), owned.data());
    for (const LocalIndex n : exchange.active_nodes()) EXPECT_TRUE(owned[n] == 0.0 && !std::signbit(owned[n]));
  });
}

}  // namespace
}  // namespace bulkley::exchange_mpi_test
