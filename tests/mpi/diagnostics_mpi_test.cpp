// ranks: 1 3
// The sums of history.csv: each term is that of its particles, whatever laws lie side by side in memory.
#include "integrator/diagnostics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "support/solver_run.hpp"

namespace bulkley::diagnostics_mpi_test {
namespace {

// Particle by particle, in plain sums.
Diagnostics plainly(const Physics& physics, const ParticleSet& set) {
  Diagnostics d;
  double fluid = 0.0, flowing = 0.0, volumes = 0.0, dilations = 0.0;
  d.lower = d.upper = set.vector(Field::position, 0);
  const double inertia = affine_inertia(physics.grid, physics.transfer);
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const Vec3 x = set.vector(Field::position, p), v = set.vector(Field::velocity, p);
    const Mat3 C = tensor(set, Field::affine_velocity, p);
    const double m = set.mass(p), V = set.real(Field::reference_volume)[p], J = set.real(Field::volume_ratio)[p];
    const Vec3 spin(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
    d.mass += m;
    d.momentum += m * v;
    d.angular_momentum += m * (x.cross(v) + inertia * spin);
    d.kinetic_energy += 0.5 * m * (v.squaredNorm() + inertia * C.squaredNorm());
    d.elastic_energy += elastic_energy(physics, set, p);
    d.gravitational_energy -= m * physics.gravity.dot(x);
    d.dissipated_energy += V * set.real(Field::plastic_dissipation)[p];
    d.center_of_mass += m * x;
    d.lower = d.lower.cwiseMin(x);
    d.upper = d.upper.cwiseMax(x);
    const bool is_fluid = flows(physics.materials[set.material()[p]].material);
    fluid += is_fluid ? m : 0.0;
    flowing += is_fluid && set.real(Field::plastic_shear_rate)[p] > 0.0 ? m : 0.0;
    volumes += V;
    dilations += V * (J - 1.0) * (J - 1.0);
  }
  d.center_of_mass /= d.mass;
  d.yielded_fraction = flowing / fluid;
  d.volume_error = std::sqrt(dilations / volumes);
  return d;
}

// After some steps; out of order, so that packs hold several laws, and of a number that fills neither packs nor blocks.
ParticleSet shuffled(const Comm& comm, const SolverScene& scene) {
  const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
  TimeStepState state;
  for (int step = 0; step < 20; ++step) solver->step({0.0, 1.0}, state);
  ParticleSet all = gathered(comm, solver->particles());
  std::vector<LocalIndex> order(static_cast<std::size_t>(all.size()));
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 generator(4);
  std::ranges::shuffle(order, generator);
  all.reorder(order);
  all.resize(all.size() - 3);
  return all;
}

class DiagnosticsTest : public testing::TestWithParam<bool> {};

TEST_P(DiagnosticsTest, EveryTermIsThatOfItsParticles) {
  const Comm comm{PETSC_COMM_WORLD};
  TransferSettings transfer;
  SolverScene scene = every_law_scene(transfer);
  if (GetParam()) make_implicit(scene.physics);
  const ParticleSet all = shuffled(comm, scene);
  ASSERT_GT(all.size(), 600);
  const Diagnostics expected = plainly(scene.physics, all);
  const Diagnostics found = diagnose(comm, scene.physics, share_of(comm, all, fields_of(scene.physics)));
  const auto near = [](double a, double b) { EXPECT_NEAR(a, b, 1e-12 * std::abs(b)); };
  EXPECT_EQ(found.n_particles, all.size());
  near(found.mass, expected.mass);
  near(found.kinetic_energy, expected.kinetic_energy);
  near(found.elastic_energy, expected.elastic_energy);
  near(found.gravitational_energy, expected.gravitational_energy);
  near(found.dissipated_energy, expected.dissipated_energy);
  near(found.yielded_fraction, expected.yielded_fraction);
  near(found.volume_error, expected.volume_error);
  EXPECT_LE((found.momentum - expected.momentum).norm(), 1e-12 * expected.mass);
  EXPECT_LE((found.angular_momentum - expected.angular_momentum).norm(), 1e-12 * expected.mass);
  EXPECT_LE((found.center_of_mass - expected.center_of_mass).norm(), 1e-12);
  EXPECT_EQ(found.lower, expected.lower);
  EXPECT_EQ(found.upper, expected.upper);
  EXPECT_GT(found.elastic_energy, 0.0);
  EXPECT_GT(found.dissipated_energy, 0.0);
  EXPECT_LT(found.yielded_fraction, 1.0);
}

INSTANTIATE_TEST_SUITE_P(Explicit, DiagnosticsTest, testing::Values(false));
INSTANTIATE_TEST_SUITE_P(Implicit, DiagnosticsTest, testing::Values(true));

// A rank without particles adds nothing.
TEST(DiagnosticsOfFew, NoneAndOne) {
  const Comm comm{PETSC_COMM_WORLD};
  SolverScene scene = empty_scene({}, {8, 8, 8}, {false, false, false});
  EXPECT_EQ(diagnose(comm, scene.physics, share_of(comm, scene.particles, {})).n_particles, 0);
  add_particle(scene, Vec3(0.1, 0.5, 0.6), Vec3(1.0, 0.0, 0.0));
  const Diagnostics one = diagnose(comm, scene.physics, share_of(comm, scene.particles, {}));
  EXPECT_EQ(one.n_particles, 1);
  EXPECT_EQ(one.lower, Vec3(0.1, 0.5, 0.6));
  EXPECT_EQ(one.upper, one.lower);
  EXPECT_EQ(one.momentum, Vec3(one.mass, 0.0, 0.0));
}

}  // namespace
}  // namespace bulkley::diagnostics_mpi_test
