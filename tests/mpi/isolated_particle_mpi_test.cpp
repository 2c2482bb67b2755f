// ranks: 1
// The longest stable step of a single particle, the worst case of an elastic body's surface, against theory ("Time step"): explicit
// with a stiff volume, and with an implicit pressure, where shear alone is explicit.
#include <gtest/gtest.h>

#include <cmath>

#include "support/solver_run.hpp"

namespace bulkley::isolated_particle_mpi_test {
namespace {

constexpr double density = 1000.0, modulus = 1e5;  // kg/m^3; Pa, of what stays explicit
constexpr double strain = 1e-6;

class IsolatedParticleTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  // By how much a small strain grows in 20 steps of elastic_cfl dx / c, c as in (T25), at the corner of a cell.
  double growth(const TransferSettings& transfer, bool implicit, double elastic_cfl) {
    SolverScene scene = empty_scene(transfer, {8, 8, 8}, {false, false, false});
    Physics& physics = scene.physics;
    const GridGeometry& grid = physics.grid;
    const double bulk_modulus = implicit ? 2e9 : modulus, shear_modulus = implicit ? modulus : 1e-3 * modulus;
    physics.materials = {{"solid", NeoHookean{{density, bulk_modulus, shear_modulus}}}};
    // As near to the corner as leaves a weight to the farthest nodes.
    add_particle(scene, grid.lower + grid.cell_size * Vec3::Constant(3.4999));
    ParticleSet& set = scene.particles;
    double& strained = implicit ? set.real(Field::left_cauchy_green, 3)[0] : set.real(Field::volume_ratio)[0];
    strained += strain;
    if (implicit) make_implicit(physics);
    const double c = std::sqrt(((implicit ? 0.0 : bulk_modulus) + 4.0 / 3.0 * shear_modulus) / density);
    TimeStepSettings& time = physics.time_stepping;
    time.dt_fixed = elastic_cfl * grid.cell_size / c;
    time.allow_unstable = true;
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
    TimeStepState state;
    double largest = 0.0;
    for (int step = 0; step < 20; ++step) {
      solver->step({0.0, 1.0}, state);
      const ParticleSet& after = solver->particles();
      const double now = implicit ? after.real(Field::left_cauchy_green, 3)[0] : after.real(Field::volume_ratio)[0] - 1.0;
      largest = std::max(largest, std::abs(now));
    }
    return largest / strain;
  }
};

TEST_F(IsolatedParticleTest, IsStableUpToTheTheoreticalStep) {
  struct Case {
    const char* what;
    GradientForm gradient;
    bool implicit;
    double limit;  // of elastic_cfl
  };
  // Of (T26b) with the second moment of the splines: g = a = 4 in the MLS form; g = 6, a = 4 with gradients.
  const Case cases[] = {{"explicit, MLS", GradientForm::mls, false, 1.0 / std::sqrt(3.0)},
                        {"explicit, gradients", GradientForm::bspline, false, 1.0 / std::sqrt(6.0)},
                        {"implicit pressure, MLS", GradientForm::mls, true, std::sqrt(2.0 / 3.0)},
                        {"implicit pressure, gradients", GradientForm::bspline, true, 1.0 / std::sqrt(3.0)}};
  for (const Case& a : cases) {
    SCOPED_TRACE(a.what);
    const TransferSettings transfer{.scheme = TransferScheme::apic, .gradient = a.gradient};
    EXPECT_LT(growth(transfer, a.implicit, 0.98 * a.limit), 12.0);
    EXPECT_GT(growth(transfer, a.implicit, 1.05 * a.limit), 30.0);
  }
}

TEST_F(IsolatedParticleTest, TheDefaultIsBelowIt) { EXPECT_LT(TimeStepSettings{}.elastic_cfl, 1.0 / std::sqrt(6.0)); }

}  // namespace
}  // namespace bulkley::isolated_particle_mpi_test
