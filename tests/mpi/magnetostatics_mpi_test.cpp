// ranks: 1 2 3 4 7
// The field of magnetic bodies on several ranks: the moment of a ball, and the same bits on any number of them.
#include <gtest/gtest.h>

#include <cstring>

#include "support/magnetic_bodies.hpp"

namespace bulkley::magnetostatics_mpi_test {
namespace {

using Setting = MagneticSetting;
using Found = MagneticFound;

// M1: the moment of a linear ball is 3 chi/(3 + chi) V H_0.
TEST(Magnetostatics, HasTheMomentOfALinearBall) {
  const Comm comm(PETSC_COMM_WORLD);
  for (const auto& [susceptibility, gate] : {std::pair{1.0, 0.02}, {10.0, 0.06}}) {
    Setting setting({20, 20, 20});
    setting.magnetisations[0] = linear(susceptibility);
    setting.ball(setting.middle(), 16.0);
    const Found found = find(comm, setting);
    ASSERT_TRUE(found.report.solved);
    const double exact = 3.0 * susceptibility / (3.0 + susceptibility) * found.volume * 1e5;
    EXPECT_NEAR(found.moment[0], exact, gate * exact) << susceptibility;
    EXPECT_NEAR(found.moment[1], 0.0, 1e-3 * exact);
    EXPECT_LE(found.report.n_iterations, 12);
    // M3: the field is uniform, so nothing pulls.
    const double magnetisation = found.moment[0] / found.volume, radius = 8.0 * setting.dx();
    EXPECT_LT(found.force.norm(), 1e-2 * 0.5 * mu0 * magnetisation * magnetisation * pi * radius * radius);
  }
}

// M10: the same bits on any number of ranks and under any map.
TEST(Magnetostatics, HasTheSameBitsOnAnyNumberOfRanks) {
  const Comm comm(PETSC_COMM_WORLD), self(MPI_COMM_SELF);
  for (const std::array<bool, 3>& periodic : {std::array{false, false, false}, {false, true, false}, {true, true, false}}) {
    Setting setting({12, 8, 16}, SplineOrder::quadratic, periodic);
    setting.settings.tolerance = 1e-3;
    setting.magnetisations = {Magnetisation{Magnetisation::Law::exponential, 5.0, 2e5}, linear(2.0)};
    setting.sources = {source_of(FieldFormula{{{"1e5+2e4*x", "3e4-2e4*y", "0"}}}),
                       source_of(Dipole{.center = Vec3(0.3, 0.6, -1.5), .moment = 3e5})};
    setting.ball(setting.middle() - Vec3(0.0, 0.0, 0.35), 6.0, Vec3(0.11, 0.27, 0.18), 0);
    setting.ball(setting.middle() + Vec3(0.0, 0.0, 0.35), 6.0, Vec3(0.3, 0.02, 0.4), 1);
    const Found alone = find(self, setting, false);
    ASSERT_TRUE(alone.report.solved);
    for (const bool scattered : {true, false}) {
      const Found found = find(comm, setting, scattered);
      EXPECT_EQ(found.report.n_iterations, alone.report.n_iterations);
      EXPECT_EQ(found.energy, alone.energy);
      EXPECT_TRUE((found.moment.array() == alone.moment.array()).all());
      int n_wrong = 0;
      for (const auto& [id, values] : found.at_particles)
        n_wrong += std::memcmp(values.data(), alone.at_particles.at(id).data(), sizeof values) != 0;
      EXPECT_EQ(n_wrong, 0);
    }
  }
}

}  // namespace
}  // namespace bulkley::magnetostatics_mpi_test
