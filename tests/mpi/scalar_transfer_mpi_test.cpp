// ranks: 1 2 3 8
// One number per particle to the nodes, to a field on the whole grid, back to the nodes and to the particles: the same bits on
// any number of ranks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "field/tile_scatter.hpp"
#include "kernel/scalar_deposit.hpp"
#include "kernel/scalar_gather.hpp"
#include "support/particle_builders.hpp"
#include "support/random_vectors.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::scalar_transfer_mpi_test {
namespace {

constexpr LocalIndex n_particles = 3000;

struct Scene {
  GridGeometry grid;
  ParticleSet particles;
  std::vector<double> q;  // by particle; its id is its place
};

// A ball across a corner of the domain, which is the middle of the material where axes are periodic.
Scene scene_of(SplineOrder order, const std::array<bool, 3>& periodic) {
  Scene scene{grid_of_cells({12, 16, 20}, periodic), ParticleSet(), {}};
  scene.grid.order = order;
  scene.particles.resize(n_particles);
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0.0, 0.25);
  for (LocalIndex p = 0; p < n_particles; ++p) {
    Vec3 x = random_vector(normal, random);
    for (int axis = 0; axis < 3; ++axis) {
      const double size = scene.grid.upper()[axis];
      x[axis] = periodic[axis] ? (x[axis] < 0.0 ? x[axis] + size : x[axis]) : std::min(std::abs(x[axis]), size);
    }
    place_particle(scene.particles, p, x, 1.0);
    scene.particles.id()[p] = p;
    scene.q.push_back(normal(random) * std::exp2(static_cast<int>(random() % 40)));
  }
  return scene;
}

struct Result {
  std::vector<double> field;                                  // by node number
  std::map<GlobalIndex, std::array<double, 4>> at_particles;  // value and gradient, by id
};

Result transfer(const Comm& comm, const Scene& scene, const TileMap& owners) {
  const GridGeometry& grid = scene.grid;
  std::vector<LocalIndex> mine;
  std::vector<TileIndex> tiles;
  for (LocalIndex p = 0; p < n_particles; ++p) {
    const TileIndex tile = grid.tile_of(scene.particles.vector(Field::position, p));
    if (owners.owner(tile) != comm.rank()) continue;
    mine.push_back(p);
    tiles.push_back(tile);
  }
  std::shuffle(mine.begin(), mine.end(), std::mt19937(static_cast<unsigned>(comm.size())));
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  const PoolLayout layout(grid, tiles);
  const ParticleSet particles = picked(scene.particles, mine);
  CellMap map;
  std::vector<OutsideParticle> outside;
  map.reset(layout, particles.size());
  locate(grid, layout, particles, map, outside);
  EXPECT_TRUE(outside.empty());

  std::vector<double> q;
  double largest = 0.0;
  for (const LocalIndex p : mine) {
    q.push_back(scene.q[static_cast<std::size_t>(p)]);
    largest = std::max(largest, std::abs(q.back()));
  }
  Exchange exchange(comm, grid, owners, layout);
  std::vector<double> pool(static_cast<std::size_t>(layout.n_nodes())), owned(static_cast<std::size_t>(exchange.n_owned()));
  scalar_deposit(grid, layout, particles, map, q.data(), max_global(comm, largest),
                 max_global(comm, GlobalIndex{map.largest_count()}), pool.data());
  exchange.add(pool.data(), owned.data());

  const FieldGrid field(comm, {.geometry = grid});
  const TileScatter scatter(comm, exchange, field);
  std::vector<double> values(field.size());
  scatter.to_field(owned.data(), values.data());
  Result result;
  result.field.assign(static_cast<std::size_t>(grid.n_nodes(0)) * grid.n_nodes(1) * grid.n_nodes(2), 0.0);
  for (LocalIndex n = 0; n < field.n_owned(); ++n)
    result.field[static_cast<std::size_t>(grid.node_number(field.node(n)))] = values[static_cast<std::size_t>(n)];
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, result.field.data(), static_cast<int>(result.field.size()), MPI_DOUBLE, MPI_SUM,
                            comm.get()));

  std::fill(owned.begin(), owned.end(), -1.0);
  std::fill(pool.begin(), pool.end(), -1.0);
  scatter.to_owned(values.data(), owned.data());
  exchange.get(owned.data(), pool.data());
  std::array<std::vector<double>, 4> found;
  for (auto& column : found) column.resize(q.size());
  scalar_gather(grid, layout, particles, map, {pool.data(), found[0].data()},
                {pool.data(), {found[1].data(), found[2].data(), found[3].data()}});
  for (LocalIndex p = 0; p < particles.size(); ++p)
    for (int c = 0; c < 4; ++c) result.at_particles[particles.id()[p]][c] = found[c][static_cast<std::size_t>(p)];
  return result;
}

TEST(ScalarTransfer, HasTheSameBitsOnAnyNumberOfRanksUnderAnyMap) {
  const Comm comm(PETSC_COMM_WORLD), self(MPI_COMM_SELF);
  for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic})
    for (const std::array<bool, 3>& periodic : {std::array{false, false, false}, {true, true, true}, {false, true, false}}) {
      const Scene scene = scene_of(order, periodic);
      const auto n_tiles = static_cast<std::size_t>(scene.grid.n_tiles());
      const Result alone = transfer(self, scene, TileMap(1, std::vector<std::int32_t>(n_tiles, 0)));
      EXPECT_EQ(alone.at_particles.size(), static_cast<std::size_t>(n_particles));
      // What nodes hold is what particles gave.
      double sum = 0.0, given = 0.0, size = 0.0;
      for (const double s : alone.field) sum += s;
      for (const double x : scene.q) given += x, size += std::abs(x);
      EXPECT_NEAR(sum, given, 1e-12 * size);

      std::mt19937 random(8);
      std::vector<std::int32_t> scattered(n_tiles), halves(n_tiles);
      for (std::size_t tile = 0; tile < n_tiles; ++tile) {
        scattered[tile] = static_cast<std::int32_t>(random() % static_cast<unsigned>(comm.size()));
        halves[tile] = static_cast<std::int32_t>(tile * static_cast<std::size_t>(comm.size()) / n_tiles);
      }
      for (const TileMap& owners : {TileMap(comm.size(), scattered), TileMap(comm.size(), halves)}) {
        const Result found = transfer(comm, scene, owners);
        EXPECT_EQ(std::memcmp(found.field.data(), alone.field.data(), alone.field.size() * sizeof(double)), 0);
        int n_wrong = 0;
        for (const auto& [id, values] : found.at_particles)
          n_wrong += std::memcmp(values.data(), alone.at_particles.at(id).data(), sizeof values) != 0;
        EXPECT_EQ(n_wrong, 0);
        EXPECT_EQ(sum_global(comm, static_cast<GlobalIndex>(found.at_particles.size())), n_particles);
      }
    }
}

}  // namespace
}  // namespace bulkley::scalar_transfer_mpi_test
