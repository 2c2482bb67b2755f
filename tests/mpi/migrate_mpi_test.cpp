// ranks: 1 2 3 4 8
#include "distribution/migrate.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <set>
#include <vector>

namespace bulkley::migrate_mpi_test {
namespace {

// Every moving element of a particle follows from its id, its destination (carried as `material`) and the column.
std::uint64_t expected_bits(GlobalIndex id, std::size_t column) {
  return (static_cast<std::uint64_t>(id) * 64 + column) * 0x9E3779B97F4A7C15ull;
}

void fill(ParticleSet& particles, LocalIndex p, GlobalIndex id, int destination) {
  for (std::size_t c = 0; c < particles.columns().size(); ++c) {
    if (particles.columns()[c].element_size != 8) continue;
    const std::uint64_t bits = expected_bits(id, c);
    std::memcpy(particles.data(c) + static_cast<std::size_t>(p) * 8, &bits, 8);
  }
  particles.id()[p] = id;
  particles.material()[p] = static_cast<std::uint8_t>(destination);
}

// Columns of particle p that do not hold what fill() wrote.
int n_damaged(const ParticleSet& particles, LocalIndex p) {
  int damaged = 0;
  for (std::size_t c = 0; c < particles.columns().size(); ++c) {
    const ParticleSet::Column& column = particles.columns()[c];
    if (column.element_size != 8 || !column.moves || column.field == Field::id) continue;
    std::uint64_t bits = 0;
    std::memcpy(&bits, particles.data(c) + static_cast<std::size_t>(p) * 8, 8);
    damaged += bits != expected_bits(particles.id()[p], c);
  }
  return damaged;
}

// Those that the departures go to, and come from.
Neighbours neighbours_for(const Comm& comm, const std::vector<Departure>& departures) {
  std::vector<int> ranks;
  for (const Departure& d : departures) ranks.push_back(d.rank);
  Neighbours neighbours(comm);
  neighbours.introduce(ranks);
  return neighbours;
}

class Migrate : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  // Migrates particles with the given destinations and checks that each arrived once, whole, where it should.
  void run(const std::vector<int>& destinations) {
    const auto n = static_cast<LocalIndex>(destinations.size());
    const GlobalIndex first_id = exclusive_sum(comm, n), n_global = sum_global(comm, n);
    ParticleSet particles(
        {Field::velocity_gradient, Field::structure, Field::viscous_left_cauchy_green, Field::added_law_variables});
    particles.resize(n);
    std::vector<Departure> departures;
    LocalIndex n_staying = 0;
    for (LocalIndex p = 0; p < n; ++p) {
      fill(particles, p, first_id + p, destinations[p]);
      if (destinations[p] != comm.rank())
        departures.push_back({p, destinations[p]});
      else
        ++n_staying;
    }
    std::shuffle(departures.begin(), departures.end(), std::mt19937(comm.rank()));

    const Neighbours neighbours = neighbours_for(comm, departures);
    const LocalIndex n_received = migrate(comm, neighbours, departures, particles);

    EXPECT_EQ(particles.size(), n_staying + n_received);
    std::set<GlobalIndex> seen;
    GlobalIndex id_sum = 0;
    for (LocalIndex p = 0; p < particles.size(); ++p) {
      const GlobalIndex id = particles.id()[p];
      EXPECT_EQ(particles.material()[p], comm.rank()) << "id " << id;
      EXPECT_EQ(n_damaged(particles, p), 0) << "id " << id;
      id_sum += id;
      const bool own = id >= first_id && id < first_id + n;
      EXPECT_EQ(own, p < n_staying) << "arrivals stand behind the particles that stayed";
      EXPECT_TRUE(seen.insert(id).second) << "id " << id << " twice";
    }
    // Nobody is lost or doubled: count and sum of the ids over all ranks.
    EXPECT_EQ(sum_global(comm, particles.size()), n_global);
    EXPECT_EQ(sum_global(comm, id_sum), n_global * (n_global - 1) / 2);
  }
};

TEST_F(Migrate, NobodyMoves) { run(std::vector<int>(1000, comm.rank())); }

TEST_F(Migrate, NoParticlesAnywhere) { run({}); }

TEST_F(Migrate, AllToOne) {
  for (int target = 0; target < comm.size(); ++target) run(std::vector<int>(200 + 10 * comm.rank(), target));
}

TEST_F(Migrate, OneToAll) {
  std::vector<int> destinations;
  if (comm.rank() == comm.size() - 1)
    for (int p = 0; p < 500; ++p) destinations.push_back(p % comm.size());
  run(destinations);
}

TEST_F(Migrate, EveryoneLeavesToTheNextRank) { run(std::vector<int>(333, (comm.rank() + 1) % comm.size())); }

TEST_F(Migrate, RandomDestinations) {
  std::mt19937 random(17 + comm.rank());
  for (int trial = 0; trial < 20; ++trial) {
    // Counts from none to many; few to all of them leave.
    std::vector<int> destinations(random() % 5 == 0 ? 0 : random() % 2000);
    std::bernoulli_distribution leaves(0.1 * (trial % 11));
    for (int& d : destinations) d = leaves(random) ? static_cast<int>(random() % comm.size()) : comm.rank();
    run(destinations);
  }
}

TEST_F(Migrate, LastParticlesFillTheGaps) {
  if (comm.size() == 1) GTEST_SKIP() << "needs a rank to send to";
  // Stay or leave in every pattern of eight particles.
  const int next = (comm.rank() + 1) % comm.size();
  for (unsigned pattern = 0; pattern < 256; ++pattern) {
    std::vector<int> destinations(8);
    for (int p = 0; p < 8; ++p) destinations[p] = pattern >> p & 1u ? next : comm.rank();
    run(destinations);
  }
}

TEST_F(Migrate, ParcelsLargerThanOneMessage) {
  // 300 000 particles of 265 bytes are more than one message of 64 MiB.
  run(std::vector<int>(comm.rank() == 0 ? 300000 : 0, comm.size() - 1));
}

TEST_F(Migrate, WithoutVelocityGradient) {
  ParticleSet particles;
  particles.resize(10);
  for (LocalIndex p = 0; p < 10; ++p) fill(particles, p, comm.rank() * 10 + p, 0);
  std::vector<Departure> departures;
  if (comm.rank() != 0)
    for (LocalIndex p = 0; p < 10; ++p) departures.push_back({p, 0});
  migrate(comm, neighbours_for(comm, departures), departures, particles);
  EXPECT_EQ(particles.size(), comm.is_root() ? 10 * comm.size() : 0);
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    EXPECT_EQ(particles.id()[p], p);  // arrivals are ordered by source rank
    EXPECT_EQ(n_damaged(particles, p), 0);
  }
}

}  // namespace
}  // namespace bulkley::migrate_mpi_test
