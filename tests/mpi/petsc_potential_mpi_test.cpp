// ranks: 1 2 4 7
// Two solvers that share no arithmetic but the operator find the same potential, on every kind of box.
#include <gtest/gtest.h>

#include "support/magnetic_bodies.hpp"

namespace bulkley::petsc_potential_mpi_test {
namespace {

using Setting = MagneticSetting;
using Found = MagneticFound;

double largest_over_ranks(const Comm& comm, const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return max_global(comm, largest);
}

// The largest difference of a node's potential, over the largest potential.
double difference_of_solvers(const Comm& comm, Setting&& setting) {
  setting.settings.tolerance = 1e-9;
  const Found own = find(comm, setting);
  setting.settings.solver = FieldSolver::petsc;
  const Found petsc = find(comm, setting);
  EXPECT_TRUE(own.report.solved && petsc.report.solved) << own.report.residual << " " << petsc.report.residual;
  EXPECT_TRUE(own.report.settled && petsc.report.settled) << own.report.change << " " << petsc.report.change;
  EXPECT_LE(petsc.report.n_iterations, 12 * petsc.report.n_sweeps);
  std::vector<double> differences = own.potential;
  for (std::size_t i = 0; i < differences.size(); ++i) differences[i] -= petsc.potential[i];
  const double result = largest_over_ranks(comm, differences) / largest_over_ranks(comm, own.potential);
  if (comm.is_root())
    std::printf("%d ranks: %.2g apart after %d and %d iterations\n", comm.size(), result, own.report.n_iterations,
                petsc.report.n_iterations);
  return result;
}

Setting ball_of(const Magnetisation& material, const std::array<bool, 3>& periodic = {false, false, false}) {
  Setting setting({12, 12, 12}, SplineOrder::quadratic, periodic);
  setting.magnetisations[0] = material;
  setting.apply({"1e5", "4e4*(y-0.5)", "2e4-4e4*(z-0.5)"});
  setting.ball(setting.middle(), 9.0);
  return setting;
}

constexpr double agreement = 1e-7;

TEST(PetscPotential, AgreesOnLinearBalls) {
  const Comm comm(PETSC_COMM_WORLD);
  for (const double susceptibility : {1.0, 10.0})
    EXPECT_LT(difference_of_solvers(comm, ball_of(linear(susceptibility))), agreement) << susceptibility;
}

TEST(PetscPotential, AgreesOnASaturatedBall) {
  const Comm comm(PETSC_COMM_WORLD);
  Setting setting = ball_of({Magnetisation::Law::langevin, 3.0, 1e5});
  setting.settings.picard_tolerance = 1e-9;
  setting.settings.picard_limit = 60;
  EXPECT_LT(difference_of_solvers(comm, std::move(setting)), agreement);
}

TEST(PetscPotential, AgreesUnderOtherFarFields) {
  const Comm comm(PETSC_COMM_WORLD);
  for (const FarField boundary : {FarField::neumann, FarField::zero}) {
    Setting setting = ball_of(linear(3.0));
    setting.settings.boundary = boundary;
    EXPECT_LT(difference_of_solvers(comm, std::move(setting)), agreement) << static_cast<int>(boundary);
  }
}

// One periodic axis of few cells, as in plane flow; two, where nothing leaks; three.
TEST(PetscPotential, AgreesAlongPeriodicAxes) {
  const Comm comm(PETSC_COMM_WORLD);
  Setting plane({12, 12, 4}, SplineOrder::quadratic, {false, false, true});
  const Vec3 middle = plane.middle();
  plane.magnetisations[0] = linear(3.0);
  plane.fill(Vec3(0.11, 0.27, 0.0), 0,
             [&](const Vec3& x) { return std::hypot(x[0] - middle[0], x[1] - middle[1]) < 4.0 * plane.dx(); });
  EXPECT_LT(difference_of_solvers(comm, std::move(plane)), agreement);
  for (const bool third : {false, true}) {
    Setting setting = ball_of(linear(3.0), {true, true, third});
    setting.apply({"1e5", "0", "2e4"});
    EXPECT_LT(difference_of_solvers(comm, std::move(setting)), agreement) << third;
  }
}

}  // namespace
}  // namespace bulkley::petsc_potential_mpi_test
