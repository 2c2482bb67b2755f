// ranks: 1 2 3 4 7
// The interface of partitioners: the one that works on the root, another that has no root, and answers that ranks must not
// accept.
#include "rebalance/partitioner.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "rebalance/automatic_partitioner.hpp"
#include "rebalance/balancer.hpp"
#include "rebalance/share.hpp"
#include "support/solver_run.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::partitioner_mpi_test {
namespace {

/// Runs of tile numbers with about equal numbers of particles. Every rank computes them from reduced counts: none gathers
/// anything.
class ChunkPartitioner final : public Partitioner {
 private:
  PartitionProposal find(const Comm& comm, const PartitionRequest& request) override {
    std::vector<GlobalIndex> counts(static_cast<std::size_t>(request.grid.n_tiles()), 0);
    for (std::size_t t = 0; t < request.census.size(); ++t)
      counts[static_cast<std::size_t>(request.census.tile[t])] += request.census.n_particles(t);
    BULKLEY_MPI(
        MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_INT64_T, MPI_SUM, comm.get()));
    const GlobalIndex total = std::accumulate(counts.begin(), counts.end(), GlobalIndex{0});
    GlobalIndex below = 0;
    PartitionProposal proposal;
    proposal.partition.emplace().map = map_by(request.grid, comm.size(), [&](TileIndex tile) {
      const GlobalIndex owner = total > 0 ? below * comm.size() / total : 0;
      below += counts[static_cast<std::size_t>(tile)];
      return std::min<GlobalIndex>(owner, comm.size() - 1);
    });
    if (request.present && request.present->map == proposal.partition->map) proposal.partition.reset();
    return proposal;
  }
};

/// Answers as a test demands.
class Scripted final : public Partitioner {
 public:
  using Answer = std::function<std::optional<TileMap>(const Comm&, const GridGeometry&)>;
  explicit Scripted(Answer answer) : answer_(std::move(answer)) {}

 private:
  PartitionProposal find(const Comm& comm, const PartitionRequest& request) override {
    PartitionProposal proposal;
    if (std::optional<TileMap> map = answer_(comm, request.grid)) proposal.partition = Partition{std::move(*map), {}};
    return proposal;
  }
  Answer answer_;
};

class PartitionerTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  GridGeometry grid = grid_of_cells({30, 41, 23});
  CostModel cost;

  /// Every rank has some particles of every tile, the later ones more.
  TileCensus local_census() const {
    TileCensus census;
    const std::vector<GlobalIndex> load = random_load(grid, 5);
    for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
      if (load[tile] == 0) continue;
      census.tile.push_back(tile);
      census.count.push_back(load[tile] * (comm.rank() + 1));
      census.cells.push_back(std::uint64_t{1} << comm.rank());
    }
    return census;
  }
  std::string error_of(Scripted::Answer answer) {
    const TileCensus census = local_census();
    try {
      Scripted(std::move(answer)).propose(comm, {grid, census, cost});
    } catch (const RunError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(PartitionerTest, EveryRankComputesTheSameMap) {
  const Partition partition = make_partition(grid, {PartitionMethod::ranges}, tile_load(random_load(grid, 3)), 12);
  const auto hash = static_cast<GlobalIndex>(partition.map.fingerprint() >> 1);
  EXPECT_EQ(min_global(comm, hash), max_global(comm, hash));
}

// With boxes and without.
TEST_F(PartitionerTest, SharingGivesEveryRankTheRootsPartition) {
  for (const GridGeometry& shape : {grid_of_cells({50, 60, 70}), grid_of_cells({4, 4, 4}, {true, true, true})}) {
    const TileLoad load = tile_load(random_load(shape, 3));
    for (const PartitionMethod method : {PartitionMethod::bisection, PartitionMethod::hilbert}) {
      const Partition cuts = make_partition(shape, {method}, load, comm.size());
      const Partition shared = share_partition(comm, comm.is_root() ? cuts : Partition{});
      EXPECT_EQ(shared.map, cuts.map);
      EXPECT_EQ(shared.map.fingerprint(), cuts.map.fingerprint());
    }
    const Partition whole = make_partition(shape, {PartitionMethod::metis}, load, comm.size());
    ASSERT_EQ(whole.boxes.has_value(), comm.size() == 1 || shape.n_tiles() > 1);
    Partition other;  // what a rank has before must not matter
    other.boxes.emplace().n_ranks = {7, 7, 7};
    other.map = TileMap(10, {9, 9, 9});
    const Partition shared = share_partition(comm, comm.is_root() ? whole : other);
    EXPECT_EQ(shared.map, whole.map);
    EXPECT_EQ(shared.boxes, whole.boxes);
    if (!whole.boxes) continue;
    EXPECT_EQ(shared.boxes->n_ranks, whole.boxes->n_ranks);
    EXPECT_EQ(shared.boxes->imbalance, whole.boxes->imbalance);
  }
}

TEST_F(PartitionerTest, TheSceneOnesMapIsThatOfAllParticles) {
  const TileCensus mine = local_census();
  TileCensus all = mine;
  for (std::size_t t = 0; t < all.size(); ++t) {
    all.count[t] = mine.count[t] / (comm.rank() + 1) * (comm.size() * (comm.size() + 1) / 2);
    all.cells[t] = (std::uint64_t{1} << comm.size()) - 1;
  }
  const TileLoad load = tile_load(all, cost);
  for (const PartitionMethod method : {PartitionMethod::hilbert, PartitionMethod::bisection, PartitionMethod::automatic}) {
    const auto partitioner = make_partitioner(comm, by(method));
    const PartitionProposal first = partitioner->propose(comm, {grid, mine, cost});
    ASSERT_TRUE(first.partition);
    EXPECT_EQ(first.partition->map, make_partition(grid, by(method), load, comm.size()).map);
    EXPECT_EQ(first.busiest_moves, 0);

    // The same particles again: nothing to change, whether it must pay or not.
    EXPECT_FALSE(partitioner->propose(comm, {grid, mine, cost, &*first.partition}).partition);
    EXPECT_FALSE(partitioner->propose(comm, {grid, mine, cost, &*first.partition, 1e9}).partition);

    if (comm.size() == 1) continue;
    const Partition crowded{map_to(grid, comm.size(), comm.size() - 1), first.partition->boxes};
    for (const std::optional<double> horizon : {std::optional<double>{}, std::optional<double>{1e9}}) {
      const PartitionProposal spread = partitioner->propose(comm, {grid, mine, cost, &crowded, horizon});
      ASSERT_TRUE(spread.partition);
      EXPECT_LT(uneven(*spread.partition, load), 1.2);
      EXPECT_EQ(spread.busiest_moves, busiest_moves(crowded.map, spread.partition->map, load));
    }
    EXPECT_FALSE(partitioner->propose(comm, {grid, mine, cost, &crowded, 0.0}).partition);  // never pays
  }
}

// Neither needs a root: ranks add up layers of boxes.
TEST_F(PartitionerTest, BoxesAreThoseOfOneProcess) {
  for (const GridGeometry& shape : {grid_of_cells({30, 41, 23}), grid_of_cells({60, 44, 24}, {false, true, false})})
    for (const std::vector<GlobalIndex>& counts :
         {random_load(shape, 5), ball_load(shape), std::vector<GlobalIndex>(shape.n_tiles(), 0)}) {
      TileCensus mine, all;  // of every third tile each rank has some
      for (TileIndex tile = 0; tile < shape.n_tiles(); ++tile) {
        const GlobalIndex count = counts[static_cast<std::size_t>(tile)];
        if (count == 0) continue;
        const bool shared = tile % 3 == 0;
        if (shared || tile % comm.size() == comm.rank()) {
          mine.tile.push_back(tile);
          mine.count.push_back(count);
          mine.cells.push_back(std::uint64_t{1} << comm.rank());
        }
        all.tile.push_back(tile);
        all.count.push_back(shared ? count * comm.size() : count);
        all.cells.push_back(1);
      }
      const TileLoad load = tile_load(all, cost);
      for (const PartitionMethod method : {PartitionMethod::uniform, PartitionMethod::ranges}) {
        const auto partitioner = make_partitioner(comm, by(method));
        const Partition expected = make_partition(shape, by(method), load, comm.size());
        const PartitionProposal first = partitioner->propose(comm, {shape, mine, cost});
        ASSERT_TRUE(first.partition);
        EXPECT_EQ(first.notes.method, method);
        EXPECT_EQ(first.partition->map, expected.map);
        EXPECT_EQ(first.partition->boxes, expected.boxes);
        EXPECT_EQ(first.partition->boxes->imbalance, expected.boxes->imbalance);
        EXPECT_FALSE(partitioner->propose(comm, {shape, mine, cost, &*first.partition}).partition);
        if (comm.size() == 1) continue;
        const Partition crowded{map_to(shape, comm.size(), comm.size() - 1), {}};
        const PartitionProposal spread = partitioner->propose(comm, {shape, mine, cost, &crowded});
        ASSERT_TRUE(spread.partition);
        EXPECT_EQ(spread.partition->map, expected.map);
      }
    }
}

TEST_F(PartitionerTest, TooFewTilesForBoxesIsAUsageErrorOfEveryRank) {
  if (comm.size() < 5) return;
  const GridGeometry shape = grid_of_cells({4, 4, 4}, {true, true, true});  // one tile
  for (const PartitionMethod method : {PartitionMethod::uniform, PartitionMethod::ranges})
    EXPECT_THROW(make_partitioner(comm, by(method))->propose(comm, {shape, {}, cost}), UsageError);
}

// With a root for few tiles; without one for more, until they are half as many.
TEST_F(PartitionerTest, TheAutomaticOneLeavesTheRootWhenTilesAreMany) {
  const TileCensus mine = local_census();
  const auto n_tiles = static_cast<std::size_t>(sum_global(comm, static_cast<GlobalIndex>(mine.size())));
  const PartitionSettings settings = by(PartitionMethod::automatic);
  RootPartitioner root(settings);
  BisectionPartitioner cuts(Cutting::planes);
  AutomaticPartitioner with(settings, n_tiles), without(settings, n_tiles - 1);
  const auto map_by = [&](Partitioner& partitioner, const TileCensus& census) {
    return partitioner.propose(comm, {grid, census, cost}).partition->map;
  };
  EXPECT_EQ(map_by(with, mine), map_by(root, mine));
  EXPECT_EQ(map_by(without, mine), map_by(cuts, mine));
  EXPECT_TRUE(comm.size() == 1 || comm.size() == 3 || map_by(root, mine) != map_by(cuts, mine)) << "nothing is told apart";
  TileCensus fewer = mine;
  const auto keep = [&](std::size_t n) {
    fewer.tile.resize(n), fewer.cells.resize(n), fewer.count.resize(n * static_cast<std::size_t>(mine.n_materials));
  };
  keep(mine.size() - mine.size() / 4);
  EXPECT_EQ(map_by(without, fewer), map_by(cuts, fewer));
  keep(mine.size() / 3);
  EXPECT_EQ(map_by(without, fewer), map_by(root, fewer));

  // In a wide box neither, however few they are.
  const GridGeometry wide = grid_of_cells({2000, 2000, 64});
  ASSERT_GT(wide.n_tiles(), most_tiles_in_table);
  const Partition even{TileMap(even_cuts(wide, comm.size())), {}};
  const auto change = [&](Partitioner& partitioner) {
    return partitioner.propose(comm, {wide, mine, cost, &even, comm.size() > 1 ? std::optional<double>{1e9} : std::nullopt})
        .partition->map;
  };
  const TileMap changed = change(with);
  EXPECT_EQ(changed, change(cuts));
  EXPECT_LE(changed.memory(), std::size_t{1024});
}

TEST_F(PartitionerTest, AMapThatRanksDoNotShareIsRefused) {
  EXPECT_EQ(error_of([](const Comm& c, const GridGeometry& g) { return scattered_map(g, c.size()); }), "no error");
  EXPECT_EQ(error_of([](const Comm&, const GridGeometry&) { return std::nullopt; }), "no error");
  const std::string other = "the partitioner proposes a map for another grid or number of ranks";
  EXPECT_EQ(error_of([](const Comm& c, const GridGeometry& g) { return scattered_map(g, c.size() + 1); }), other);
  EXPECT_EQ(error_of([](const Comm& c, const GridGeometry&) { return TileMap(c.size(), {0, 0}); }), other);
  if (comm.size() == 1) return;
  const std::string different = "the partitioner proposes different maps on different ranks";
  EXPECT_EQ(error_of([](const Comm& c, const GridGeometry& g) {
              return map_by(g, c.size(), [&](TileIndex tile) { return tile == 7 && c.rank() == 1 ? 1 : 0; });
            }),
            different);
  EXPECT_EQ(error_of([](const Comm& c, const GridGeometry& g) {
              return c.is_root() ? std::optional(scattered_map(g, c.size())) : std::nullopt;
            }),
            different);
}

// --- a second partitioner in a run -------------------------------------------------------------------------------------

/// The particles after some steps from the partitioner's first map on, with checks and changes by it. After some steps one
/// rank gets all particles.
ParticleSet run_by(const Comm& comm, const SolverScene& scene, std::unique_ptr<Partitioner> partitioner,
                   const PartitionSettings& settings, BalanceTotals& totals) {
  const auto n_materials = static_cast<int>(scene.physics.materials.size());
  const TileCensus census = take_census(scene.physics.grid, share_of(comm, scene.particles, fields_of(scene.physics)),
                                        n_materials);  // tiles of many ranks
  PartitionProposal first = partitioner->propose(comm, {scene.physics.grid, census, CostModel{}});
  const auto solver = solver_of(comm, scene, std::move(*first.partition));
  Balancer balancer(comm, settings, CostMeter(), 0, std::move(partitioner));
  TimeStepState state;
  for (int step = 1; step <= 30; ++step) {
    solver->step({0.0, 1.0}, state);
    if (step == 5) solver->adopt({map_to(scene.physics.grid, comm.size(), comm.size() - 1), {}});
    balancer.after_step(*solver, step);
  }
  totals = balancer.totals();
  return gathered(comm, solver->particles());
}

TEST_F(PartitionerTest, OneWithoutARootGivesTheSameParticles) {
  SolverScene scenes[] = {contact_scene(some_transfers()[0]),
                          periodic_scene(some_transfers()[3], {12, 8, 8}, {true, true, true})};
  for (SolverScene& scene : scenes) {
    scene.physics.time_stepping = {};
    for (const PartitionSettings& settings :
         {PartitionSettings{PartitionMethod::automatic, 5, 0}, PartitionSettings{PartitionMethod::automatic, 0, 3}}) {
      BalanceTotals by_root, by_chunks;
      const ParticleSet expected = run_by(comm, scene, make_partitioner(comm, settings), settings, by_root);
      const ParticleSet found = run_by(comm, scene, std::make_unique<ChunkPartitioner>(), settings, by_chunks);
      EXPECT_EQ(expected.size(), scene.particles.size());
      EXPECT_TRUE(same_particles(expected, found));
      EXPECT_EQ(by_chunks.n_repartitions > 0, comm.size() > 1);
    }
  }
}

}  // namespace
}  // namespace bulkley::partitioner_mpi_test
