// ranks: 1 2 3 4 5 6 7 8
// Nodal values on their way from the ranks that own them because of their particles to a field on the whole grid, and back.
#include "field/tile_scatter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "balance/partition.hpp"
#include "balance/ranges.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::tile_scatter_mpi_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Map {
  std::string name;
  TileMap map;
};

// The maps of all methods, and maps that no method would make.
std::vector<Map> maps_of(const GridGeometry& grid, int n_ranks) {
  const TileLoad load = tile_load(ball_load(grid));
  std::vector<Map> maps;
  for (const auto& [name, method] : {std::pair{"uniform", PartitionMethod::uniform},
                                     {"ranges", PartitionMethod::ranges},
                                     {"hilbert", PartitionMethod::hilbert},
                                     {"metis", PartitionMethod::metis},
                                     {"auto", PartitionMethod::automatic}}) {
    const bool needs_boxes = method == PartitionMethod::uniform || method == PartitionMethod::ranges;
    if (needs_boxes && !box_fault(grid, n_ranks).empty()) continue;
    maps.push_back({name, make_partition(grid, {method}, load, n_ranks).map});
  }
  std::mt19937 random(5);
  const auto n_tiles = static_cast<std::size_t>(grid.n_tiles());
  for (const char* name : {"random", "another random"}) {
    std::vector<std::int32_t> owners(n_tiles);
    for (std::int32_t& rank : owners) rank = static_cast<std::int32_t>(random() % n_ranks);
    maps.push_back({name, TileMap(n_ranks, std::move(owners))});
  }
  maps.push_back({"all on the last rank", TileMap(n_ranks, std::vector<std::int32_t>(n_tiles, n_ranks - 1))});
  return maps;
}

class TileScatterTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  // `check(grid, layout of this rank's pool, exchange)` for grids, maps, and tiles in use: all, a ball of them, or none.
  void for_each_exchange(const std::function<void(const GridGeometry& grid, const std::vector<PoolLayout>& pools,
                                                  const Exchange& exchange)>& check) {
    const GridGeometry grids[] = {grid_of_cells({13, 22, 9}), grid_of_cells({16, 12, 20}, {true, true, true}),
                                  grid_of_cells({14, 16, 4}, {false, true, true})};
    for (const GridGeometry& grid : grids)
      for (const Map& map : maps_of(grid, comm.size()))
        for (const int in_use : {0, 1, 3}) {  // every so many tiles
          SCOPED_TRACE(testing::Message() << map.name << ", " << grid.n_cells[0] << " cells, " << in_use);
          std::vector<PoolLayout> pools;
          for (int rank = 0; rank < comm.size(); ++rank) {
            std::vector<TileIndex> tiles;
            for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile)
              if (map.map.owner(tile) == rank && in_use > 0 && tile % in_use == 0) tiles.push_back(tile);
            pools.emplace_back(grid, std::move(tiles));
          }
          const Exchange exchange(comm, grid, map.map, pools[static_cast<std::size_t>(comm.rank())]);
          check(grid, pools, exchange);
        }
  }
};

// Of a node, different for all nodes and components.
double value_of(const GridGeometry& grid, const Int3& node, int component) {
  return 1.0 + static_cast<double>(grid.node_number(node)) * 8.0 + component;
}

// By node number: whether some pool reaches it.
std::vector<bool> reached(const GridGeometry& grid, const std::vector<PoolLayout>& pools) {
  std::vector<bool> result(static_cast<std::size_t>(grid.n_nodes(0)) * grid.n_nodes(1) * grid.n_nodes(2), false);
  for (const PoolLayout& pool : pools)
    for (const NodeRow& row : pool.rows())
      for (int n = 0; n < row.count; ++n) {
        Int3 node{row.i, row.j, row.k + n};
        bool exists = true;
        for (int axis = 0; axis < 3; ++axis) {
          if (grid.periodic[axis]) node[axis] %= grid.n_nodes(axis);
          exists = exists && node[axis] < grid.n_nodes(axis);
        }
        if (exists) result[static_cast<std::size_t>(grid.node_number(node))] = true;
      }
  return result;
}

TEST_F(TileScatterTest, ThereAndBackNothingChanges) {
  for (const int n_components : {1, 4}) {
    for_each_exchange([&](const GridGeometry& grid, const std::vector<PoolLayout>& pools, const Exchange& exchange) {
      const FieldGrid field(comm, {.geometry = grid, .n_components = n_components});
      const TileScatter scatter(comm, exchange, field);
      const std::vector<bool> in_reach = reached(grid, pools);
      const std::vector<Int3> positions = exchange.active_positions();
      const auto size = static_cast<std::size_t>(exchange.n_owned()) * n_components;
      for (int round = 0; round < 2; ++round) {  // one scatter serves any number of times
        std::vector<double> owned(size, nan), values(field.size(), -5.0);
        for (std::size_t a = 0; a < positions.size(); ++a)
          for (int c = 0; c < n_components; ++c)
            owned[static_cast<std::size_t>(exchange.active_nodes()[a]) * n_components + c] =
                value_of(grid, positions[a], c) + round;
        scatter.to_field(owned.data(), values.data());
        int n_wrong = 0;
        for (LocalIndex n = 0; n < field.n_owned(); ++n)
          for (int c = 0; c < n_components; ++c) {
            const Int3 node = field.node(n);
            const double expected =
                in_reach[static_cast<std::size_t>(grid.node_number(node))] ? value_of(grid, node, c) + round : 0.0;
            n_wrong += values[static_cast<std::size_t>(n) * n_components + c] != expected;
          }
        EXPECT_EQ(n_wrong, 0) << "in the field";

        std::vector<double> back(size, -7.0);
        scatter.to_owned(values.data(), back.data());
        std::vector<bool> active(static_cast<std::size_t>(exchange.n_owned()), false);
        for (const LocalIndex n : exchange.active_nodes()) active[static_cast<std::size_t>(n)] = true;
        for (std::size_t n = 0; n < size; ++n) n_wrong += back[n] != (active[n / n_components] ? owned[n] : -7.0);
        EXPECT_EQ(n_wrong, 0) << "back with the owners";
      }
    });
  }
}

// A field that reaches beyond the grid of the particles, with ghosts, as a solve in the space around them needs it.
TEST_F(TileScatterTest, FieldsMayReachBeyondTheGrid) {
  for_each_exchange([&](const GridGeometry& grid, const std::vector<PoolLayout>& pools, const Exchange& exchange) {
    FieldLayout layout{.geometry = grid, .stencil_width = 1};
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!grid.periodic[axis]) layout.below[axis] = 3, layout.above[axis] = 2;
    const FieldGrid field(comm, layout);
    const TileScatter scatter(comm, exchange, field);
    std::vector<double> owned(static_cast<std::size_t>(exchange.n_owned()), nan), values(field.size(), nan);
    const std::vector<Int3> positions = exchange.active_positions();
    for (std::size_t a = 0; a < positions.size(); ++a) owned[exchange.active_nodes()[a]] = value_of(grid, positions[a], 0);
    scatter.to_field(owned.data(), values.data());
    const std::vector<bool> in_reach = reached(grid, pools);
    int n_wrong = 0;
    for (LocalIndex n = 0; n < field.n_owned(); ++n) {
      const Int3 node = field.node(n);
      bool inside = true;
      for (int axis = 0; axis < 3; ++axis) inside = inside && node[axis] >= 0 && node[axis] < grid.n_nodes(axis);
      const bool is_reached = inside && in_reach[static_cast<std::size_t>(grid.node_number(node))];
      n_wrong += values[static_cast<std::size_t>(n)] != (is_reached ? value_of(grid, node, 0) : 0.0);
    }
    EXPECT_EQ(n_wrong, 0);
  });
}

// The first user's round trip: ghosts of a field that came from the particles' side.
TEST_F(TileScatterTest, TheFieldsGhostsHoldTheNeighboursValues) {
  const GridGeometry grid = grid_of_cells({12, 8, 16}, {true, true, true});
  const Map map = maps_of(grid, comm.size()).back();
  const PoolLayout pool(grid, owned_tiles(map.map, comm.rank()));
  const Exchange exchange(comm, grid, map.map, pool);
  const FieldGrid field(comm, {.geometry = grid, .stencil_width = 1});
  const TileScatter scatter(comm, exchange, field);
  std::vector<double> owned(static_cast<std::size_t>(exchange.n_owned()), nan);
  const std::vector<Int3> positions = exchange.active_positions();
  for (std::size_t a = 0; a < positions.size(); ++a) owned[exchange.active_nodes()[a]] = value_of(grid, positions[a], 0);

  const VecHandle global = field.has_nodes() ? field.create_global() : VecHandle();
  std::vector<double> none;
  PetscScalar* values = none.data();
  if (field.has_nodes()) BULKLEY_PETSC(VecGetArray(global.get(), &values));
  scatter.to_field(owned.data(), values);
  if (!field.has_nodes()) return;
  BULKLEY_PETSC(VecRestoreArray(global.get(), &values));
  const VecHandle ghosted = field.create_local();
  BULKLEY_PETSC(DMGlobalToLocal(field.dm(), global.get(), INSERT_VALUES, ghosted.get()));
  PetscScalar*** phi = nullptr;
  BULKLEY_PETSC(DMDAVecGetArrayRead(field.dm(), ghosted.get(), &phi));
  int n_wrong = 0;
  for (LocalIndex n = 0; n < field.n_owned(); ++n)
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        Int3 next = field.node(n);
        next[axis] += step;
        const double found = phi[next[0]][next[1]][next[2]];
        next[axis] = (next[axis] + grid.n_nodes(axis)) % grid.n_nodes(axis);
        n_wrong += found != value_of(grid, next, 0);
      }
  BULKLEY_PETSC(DMDAVecRestoreArrayRead(field.dm(), ghosted.get(), &phi));
  EXPECT_EQ(n_wrong, 0);
}

}  // namespace
}  // namespace bulkley::tile_scatter_mpi_test
