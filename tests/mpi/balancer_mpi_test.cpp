// ranks: 1 2 3 4 5 7 8
// Maps that change while particles move: nothing but their ranks does; and when the balancer thinks that a change pays.
#include "rebalance/balancer.hpp"
#include "rebalance/share.hpp"

#include <gtest/gtest.h>

#include <random>

#include "balance/traffic.hpp"
#include "support/solver_run.hpp"
#include "support/tile_loads.hpp"

namespace bulkley {
namespace {

constexpr PartitionMethod all_methods[] = {PartitionMethod::uniform, PartitionMethod::ranges, PartitionMethod::hilbert,
                                           PartitionMethod::metis, PartitionMethod::automatic};

class BalancerTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  Comm self{MPI_COMM_SELF};

  static ParticleSet run_alone(const Comm& self, const SolverScene& scene, int n_steps) {
    const auto solver = solver_of(self, scene, partition_of(self, scene, PartitionMethod::ranges));
    TimeStepState state;
    for (int step = 0; step < n_steps; ++step) solver->step(1.0, 0, state);
    return gathered(self, solver->particles());
  }
  GlobalIndex n_particles_global(const Solver& solver) { return sum_global(comm, GlobalIndex{solver.particles().size()}); }
};

std::vector<SolverScene> moving_scenes() {
  std::vector<SolverScene> scenes;
  for (const TransferSettings& transfer : {some_transfers()[0], some_transfers()[3]}) {
    scenes.push_back(contact_scene(transfer));
    scenes.push_back(periodic_scene(transfer, {12, 8, 8}, {true, true, true}));
  }
  scenes.push_back(every_law_scene(some_transfers()[2]));
  for (SolverScene& scene : scenes) scene.physics.time_stepping = {};
  return scenes;
}

// --- a change of maps changes no particle ------------------------------------------------------------------------------

TEST_F(BalancerTest, AnyMapAfterAnyStepLeavesTheSameParticles) {
  constexpr int n_steps = 30;
  for (const SolverScene& scene : moving_scenes()) {
    SCOPED_TRACE(describe(scene.physics.transfer));
    const ParticleSet alone = run_alone(self, scene, n_steps);
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::uniform));
    TimeStepState state;
    std::mt19937 random(1);
    GlobalIndex moved = 0;
    for (int step = 0; step < n_steps; ++step) {
      solver->step(1.0, 0, state);
      Partition partition = partition_of(comm, scene, all_methods[random() % 2]);  // boxes change, too
      for (std::int32_t& worker : partition.worker) worker = static_cast<std::int32_t>(random() % comm.size());
      if (step % 7 == 6) std::fill(partition.worker.begin(), partition.worker.end(), comm.size() - 1);  // all on one rank
      moved += solver->adopt(std::move(partition));
      EXPECT_EQ(n_particles_global(*solver), scene.particles.size());
      EXPECT_EQ(solver->bounds().transport.largest_share, max_global(comm, GlobalIndex{solver->particles().size()}));
    }
    EXPECT_TRUE(same_particles(alone, gathered(comm, solver->particles())));
    if (comm.size() > 1) {
      EXPECT_GT(moved, 10 * alone.size());
    } else {
      EXPECT_EQ(moved, 0);
    }
  }
}

TEST_F(BalancerTest, CountsTheParticlesThatChangeRanks) {
  const SolverScene scene = contact_scene(some_transfers()[0]);
  const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::uniform));
  TimeStepState state;
  for (int step = 0; step < 5; ++step) solver->step(1.0, 0, state);
  const Partition before = solver->partition(), after = partition_of(comm, scene, PartitionMethod::uniform, true);
  const TileLoad load = tile_load(gather_census(comm, solver->census()), {});  // the root's
  const GlobalIndex expected = n_moved(before, after, load);
  const GlobalIndex moved = solver->adopt(after);
  EXPECT_EQ(max_global(comm, comm.is_root() ? moved - expected : 0), 0);
  EXPECT_EQ(min_global(comm, comm.is_root() ? moved - expected : 0), 0);
  EXPECT_EQ(solver->adopt(after), 0);
}

TEST_F(BalancerTest, ANewMapAfterEveryStepByEveryMethod) {
  constexpr int n_steps = 25;
  for (const SolverScene& scene : moving_scenes()) {
    const ParticleSet alone = run_alone(self, scene, n_steps);
    for (const PartitionMethod method : all_methods) {
      const bool needs_boxes = method == PartitionMethod::uniform || method == PartitionMethod::ranges;
      if (needs_boxes && !box_fault(scene.physics.grid, comm.size()).empty()) continue;
      SCOPED_TRACE(describe(scene.physics.transfer) + ", method " + std::to_string(static_cast<int>(method)));
      Partition start = partition_of(comm, scene, PartitionMethod::uniform);
      std::fill(start.worker.begin(), start.worker.end(), comm.size() - 1);  // all on one rank
      const auto solver = solver_of(comm, scene, std::move(start));
      const PartitionSettings settings{method, 0, 1};
      Balancer balancer(comm, settings, {}, 0);
      TimeStepState state;
      for (int step = 1; step <= n_steps; ++step) {
        solver->step(1.0, 0, state);
        balancer.after_step(*solver, step);
      }
      EXPECT_TRUE(same_particles(alone, gathered(comm, solver->particles())));
      EXPECT_LE(balancer.totals().n_repartitions, n_steps);
      EXPECT_EQ(balancer.totals().n_repartitions == 0, comm.size() == 1);
      const std::vector<GlobalIndex> same{balancer.totals().n_repartitions, balancer.totals().n_moved};
      for (const GlobalIndex number : same) EXPECT_EQ(max_global(comm, number), min_global(comm, number));
    }
  }
}

TEST_F(BalancerTest, AutoBringsParticlesFromOneRankToAll) {
  if (comm.size() == 1) return;
  SolverScene scene = empty_scene(some_transfers()[0], {32, 32, 8}, {false, false, false});
  add_block(scene, scene.physics.grid.lower + Vec3(0.4, 0.4, 0.1), {40, 40, 10}, 1, Vec3(0.5, 0.0, 0.0));
  scene.physics.time_stepping = {};
  Partition partition = partition_of(comm, scene, PartitionMethod::uniform);
  std::fill(partition.worker.begin(), partition.worker.end(), 0);
  const auto solver = solver_of(comm, scene, std::move(partition));
  Balancer balancer(comm, {PartitionMethod::automatic, 20, 0}, {}, 0);
  TimeStepState state;
  for (int step = 1; step <= 100; ++step) {
    solver->step(1.0, 0, state);
    balancer.after_step(*solver, step);
  }
  EXPECT_GE(balancer.totals().n_repartitions, 1);
  const double mean = static_cast<double>(scene.particles.size()) / comm.size();
  EXPECT_LT(static_cast<double>(solver->bounds().transport.largest_share), 1.3 * mean);
  EXPECT_GT(balancer.cost().of_particle(1), 1.0);  // ns
  EXPECT_LT(balancer.cost().of_particle(1), 1e5);
  EXPECT_GT(balancer.cost().node, 0.0);
  EXPECT_GT(balancer.totals().seconds, 0.0);
}

TEST_F(BalancerTest, WithoutParticlesThereIsNothingToBalance) {
  SolverScene scene = empty_scene(some_transfers()[0], {16, 16, 8}, {false, false, false});
  for (const int remake : {0, 1}) {
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::uniform));
    const PartitionSettings settings{PartitionMethod::automatic, 5, remake};
    Balancer balancer(comm, settings, {}, 0);
    for (int step = 1; step <= 30; ++step) balancer.after_step(*solver, step);
    EXPECT_EQ(balancer.totals().n_moved, 0);
    EXPECT_EQ(n_particles_global(*solver), 0);
  }
}

// --- when a change pays --------------------------------------------------------------------------------------------------

// Pure functions of loads; every rank does the same.
class WorthwhileChange : public testing::Test {
 protected:
  static constexpr int n_ranks = 6;
  GridGeometry grid = grid_of_cells({60, 60, 60});
  TileLoad load = of_ball(0);
  Partition even = make_partition(grid, {PartitionMethod::metis}, load, n_ranks);
  ChangeCost change{1e-3, 1e-3, 1e-6, 1e-5};
  double exchange = predicted_exchange(predict_traffic(grid, even, load), {});

  // The ball, each tile heavier by `slope` parts in a thousand for every tile further along x.
  TileLoad of_ball(int slope) const {
    std::vector<GlobalIndex> weights = ball_load(grid);
    for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile)
      weights[tile] += weights[tile] * slope * grid.tile_coordinates(tile)[0] / 1000;
    TileLoad result = tile_load(weights);
    for (GlobalIndex& weight : result.weight) weight *= 80'000;  // ps
    return result;
  }
  double largest(const Partition& partition, const TileLoad& loads) const {
    return imbalance(rank_loads(partition, loads, n_ranks));
  }
};

TEST_F(WorthwhileChange, NoneWhereLoadsAreEven) {
  EXPECT_LT(largest(even, load), 1.021);
  EXPECT_FALSE(worthwhile_change(grid, load, even, {}, change, 1e9, exchange).partition);
}

TEST_F(WorthwhileChange, OneWhereItPaysForLongEnough) {
  const TileLoad uneven = of_ball(100);
  const double before = largest(even, uneven);
  ASSERT_GT(before, 1.1);
  EXPECT_FALSE(worthwhile_change(grid, uneven, even, {}, change, 1.0, exchange).partition);
  const Change found = worthwhile_change(grid, uneven, even, {}, change, 1000.0, exchange);
  ASSERT_TRUE(found.partition);
  EXPECT_LT(largest(*found.partition, uneven), 1.05);
  // It moves little more than the surplus.
  EXPECT_LT(static_cast<double>(n_moved(even, *found.partition, uneven)),
            0.25 * static_cast<double>(std::accumulate(uneven.count.begin(), uneven.count.end(), GlobalIndex{0})));
}

TEST_F(WorthwhileChange, TheMoreExpensiveTheChangeTheLongerItTakesToPay) {
  const TileLoad uneven = of_ball(100);
  const auto shortest_horizon = [&](const ChangeCost& price) {
    double horizon = 1.0;
    while (horizon < 1e12 && !worthwhile_change(grid, uneven, even, {}, price, horizon, exchange).partition) horizon *= 2.0;
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
  for (std::size_t tile = 0; tile < tattered.worker.size(); ++tile)
    tattered.worker[tile] = static_cast<std::int32_t>(tile * 7919 % 101 % n_ranks);
  CostModel slow_network;
  slow_network.byte = 5.0;
  const double fresh = predicted_exchange(predict_traffic(grid, even, load), slow_network);
  const Change found = worthwhile_change(grid, load, tattered, slow_network, change, 1e5, fresh);
  ASSERT_TRUE(found.partition);
  EXPECT_TRUE(found.whole);
  EXPECT_LT(predicted_exchange(predict_traffic(grid, *found.partition, load), slow_network), 1.5 * fresh);
}

// With fewer tiles than ranks the mean is out of reach: no whole new map is made in the hope of it.
TEST_F(WorthwhileChange, NoneIsSoughtWhereEveryTileHasItsRank) {
  const GridGeometry small = grid_of_cells({8, 8, 8});
  TileLoad tiles = tile_load(std::vector<GlobalIndex>(27, 300));
  for (GlobalIndex& weight : tiles.weight) weight *= 80'000;  // ps
  const Partition each = make_partition(small, {PartitionMethod::automatic}, tiles, 40);
  const double fresh = predicted_exchange(predict_traffic(small, each, tiles), {});
  const Change found = worthwhile_change(small, tiles, each, {}, change, 1e9, fresh);
  EXPECT_FALSE(found.partition);
  EXPECT_EQ(found.making, 0.0);
  Partition crowded = each;
  std::fill(crowded.worker.begin(), crowded.worker.end(), 39);
  EXPECT_TRUE(worthwhile_change(small, tiles, crowded, {}, change, 1e9, fresh).partition);
}

TEST_F(WorthwhileChange, NoneWithoutParticles) {
  EXPECT_FALSE(worthwhile_change(grid, TileLoad{}, even, {}, change, 1e9, 0.0).partition);
}

}  // namespace
}  // namespace bulkley
