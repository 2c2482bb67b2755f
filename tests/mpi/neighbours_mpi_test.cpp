// ranks: 1 2 3 4 8
// Neighbours, the plans that they trade and the particles that they send each other, under delays: every message of this program
// leaves up to a millisecond late, so that ranks are ahead of and behind each other in every way.
#include "distribution/neighbours.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>
#include <set>
#include <thread>

#include "distribution/particle_grid.hpp"
#include "support/random_vectors.hpp"
#include "support/tile_loads.hpp"

namespace {

void delay() {
  static std::mt19937 random = [] {
    int rank = 0;
    PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return std::mt19937(static_cast<unsigned>(rank));
  }();
  if (random() % 4 == 0) std::this_thread::sleep_for(std::chrono::microseconds(random() % 1000));
}

}  // namespace

// In place of the library's, for all code of this program. PETSc counts calls by macros of these names.
#undef MPI_Isend
#undef MPI_Issend
#undef MPI_Ibarrier
extern "C" {
int MPI_Isend(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  delay();
  return PMPI_Isend(data, n, type, to, tag, comm, request);
}
int MPI_Issend(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  delay();
  return PMPI_Issend(data, n, type, to, tag, comm, request);
}
int MPI_Ibarrier(MPI_Comm comm, MPI_Request* request) {
  delay();
  return PMPI_Ibarrier(comm, request);
}
}

namespace bulkley::neighbours_mpi_test {
namespace {

class NeighboursTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  GridGeometry grid() const {
    GridGeometry geometry;
    geometry.cell_size = 0.1;
    geometry.n_cells = {24, 16, 16};
    geometry.periodic = {true, false, false};
    return geometry;
  }
  Partition partition_of(const GridGeometry& geometry) const {
    return make_partition(geometry, {PartitionMethod::ranges},
                          tile_load(std::vector<GlobalIndex>(static_cast<std::size_t>(geometry.n_tiles()), 1)), comm.size());
  }
};

TEST_F(NeighboursTest, AreMutualWhoeverIntroducedThem) {
  std::mt19937 common(7);  // what every rank wants in every round, known to all
  for (int round = 0; round < 60; ++round) {
    Neighbours neighbours(comm);
    std::vector<std::set<int>> expected(static_cast<std::size_t>(comm.size()));
    for (int call = 0; call < 3; ++call) {
      std::vector<int> mine;
      for (int rank = 0; rank < comm.size(); ++rank)
        for (unsigned n = common() % 3; n > 0; --n) {
          const int other = static_cast<int>(common() % static_cast<unsigned>(comm.size()));
          if (rank == comm.rank()) mine.push_back(other);
          if (other == rank) continue;
          expected[static_cast<std::size_t>(rank)].insert(other);
          expected[static_cast<std::size_t>(other)].insert(rank);
        }
      neighbours.introduce(mine);
      const std::set<int>& known = expected[static_cast<std::size_t>(comm.rank())];
      EXPECT_EQ(std::vector<int>(neighbours.ranks().begin(), neighbours.ranks().end()),
                std::vector<int>(known.begin(), known.end()));
      for (int rank = 0; rank < comm.size(); ++rank) EXPECT_EQ(neighbours.has(rank), known.count(rank) > 0);
    }
    neighbours.forget();
    EXPECT_TRUE(neighbours.ranks().empty());
  }
}

// One rank's pool changes: only those that own nodes which it reaches otherwise than before have to do with it.
TEST_F(NeighboursTest, APlanThatChangesConcernsItsTwoRanksAlone) {
  const GridGeometry geometry = grid();
  const Partition partition = partition_of(geometry);
  const auto tiles_of = [&](int rank) { return owned_tiles(partition.map, rank); };
  Exchange exchange(comm, geometry);
  exchange.set_pool(partition.map, PoolLayout(geometry, tiles_of(comm.rank())));
  Neighbours neighbours(comm);
  neighbours.introduce(exchange.owners());
  EXPECT_TRUE(exchange.connect(neighbours));
  EXPECT_FALSE(exchange.connect(neighbours));

  // The last rank gives up the last of its tiles.
  const int changing = comm.size() - 1;
  std::vector<TileIndex> tiles = tiles_of(changing);
  const std::vector<TileIndex> last{tiles.back()};
  tiles.pop_back();
  if (comm.rank() == changing) exchange.set_pool(partition.map, PoolLayout(geometry, tiles));
  const bool changed = exchange.connect(neighbours);
  std::vector<int> concerns(static_cast<std::size_t>(comm.size()), 0);
  if (comm.rank() == changing) {
    Exchange alone(comm, geometry);
    alone.set_pool(partition.map, PoolLayout(geometry, last));
    for (const int rank : alone.owners()) concerns[static_cast<std::size_t>(rank)] = 1;
    concerns[static_cast<std::size_t>(changing)] = 1;
  }
  MPI_Bcast(concerns.data(), comm.size(), MPI_INT, changing, comm.get());
  const bool concerned = concerns[static_cast<std::size_t>(comm.rank())] != 0;
  EXPECT_TRUE(concerned || !changed);
  EXPECT_TRUE(changed || comm.rank() != changing);
  EXPECT_FALSE(exchange.connect(neighbours));
}

// Particles walk about, and some of them leap to anywhere: each ends at the owner of its tile, and plans that have been followed for
// long exchange the same as new ones.
TEST_F(NeighboursTest, FollowParticlesThatWalkAndLeap) {
  const GridGeometry geometry = grid();
  std::mt19937 random(static_cast<unsigned>(31 + comm.rank()));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Vec3 lower = geometry.lower, size = geometry.upper() - geometry.lower;
  const auto anywhere = [&] { return Vec3(lower + size.cwiseProduct(random_vector(unit, random))); };
  ParticleSet particles;
  constexpr LocalIndex n = 40;
  particles.resize(n);
  for (LocalIndex p = 0; p < n; ++p) {
    particles.id()[p] = comm.rank() * GlobalIndex{n} + p;
    particles.material()[p] = 0;
    const Vec3 x = anywhere();
    for (int a = 0; a < 3; ++a) particles.real(Field::position, a)[p] = x[a];
  }
  PhaseTimes times;
  Faces faces;
  ParticleGrid following(comm, geometry, faces, 1, partition_of(geometry), std::move(particles), times);
  GlobalIndex n_rebuilt = 0;
  for (int step = 0; step < 60; ++step) {
    ParticleSet& set = following.particles();
    for (LocalIndex p = 0; p < set.size(); ++p) {
      const bool leaps = random() % 200 == 0;
      const Vec3 leap = anywhere();
      for (int a = 0; a < 3; ++a) {
        double& x = set.real(Field::position, a)[p];
        x = leaps ? leap[a] : std::clamp(x + 0.09 * (2.0 * unit(random) - 1.0), lower[a] + 1e-9, lower[a] + size[a] - 1e-9);
      }
    }
    const GlobalIndex before = following.local_version();
    following.begin_move();
    following.place({});
    following.finish_move({});
    n_rebuilt += following.local_version() > before;
    ASSERT_FALSE(following.bounds().failed());
    ASSERT_EQ(following.bounds().totals.n_particles, GlobalIndex{n} * comm.size());
    ASSERT_EQ(sum_global(comm, GlobalIndex{following.particles().size()}), GlobalIndex{n} * comm.size());
    int n_wrong = 0;
    for (LocalIndex p = 0; p < set.size(); ++p)
      n_wrong += following.partition().map.owner(geometry.tile_of(set.vector(Field::position, p))) != comm.rank();
    EXPECT_EQ(n_wrong, 0);

    Exchange fresh(comm, geometry, following.partition().map, following.layout());
    ASSERT_EQ(following.exchange().active_positions(), fresh.active_positions());
    std::vector<NodePair> pool(static_cast<std::size_t>(following.layout().n_nodes()));
    for (NodePair& pair : pool)
      for (int c = 0; c < 4; ++c) {
        pair.motion.c[c] = static_cast<double>(random() % 1000);
        pair.change.c[c] = static_cast<double>(random() % 1000);
      }
    const auto sums = [&](Exchange& exchange) {
      std::vector<Node> motion(static_cast<std::size_t>(exchange.n_owned())), change(motion.size()), result;
      exchange.add(pool.data(), motion.data(), change.data());
      for (const LocalIndex at : exchange.active_nodes()) {
        result.push_back(motion[static_cast<std::size_t>(at)]);
        result.push_back(change[static_cast<std::size_t>(at)]);
      }
      std::vector<NodePair> back(pool.size());
      exchange.get(motion.data(), change.data(), back.data());
      for (const NodePair& pair : back) {
        result.push_back(pair.motion);
        result.push_back(pair.change);
      }
      return result;
    };
    const std::vector<Node> followed = sums(following.exchange()), anew = sums(fresh);
    ASSERT_EQ(followed.size(), anew.size());
    EXPECT_EQ(std::memcmp(followed.data(), anew.data(), anew.size() * sizeof(Node)), 0);
    if (step % 20 == 19) following.adopt(partition_of(geometry));
  }
  EXPECT_GT(sum_global(comm, n_rebuilt), 0);
}

}  // namespace
}  // namespace bulkley::neighbours_mpi_test
