// The rate at which residuals decay, and the share that a step keeps.

#include <gtest/gtest.h>

#include <cmath>

#include "kernel/transfer.hpp"
#include "material/material.hpp"

namespace bulkley::damping_test {
namespace {

constexpr double dx = 0.01, shear_wave_speed = 3.0;

MotionBounds motion_of(double velocity_gradient, double viscosity) {
  MotionBounds motion;
  motion.velocity_gradient.include(velocity_gradient, 1);
  motion.viscosity.include(viscosity, 1);
  return motion;
}

TEST(Damping, MomentFlipDecaysWithTheStrainAndWithShearWavesAndViscosity) {
  const TransferSettings settings{.scheme = TransferScheme::moment_flip, .damping_strain = 0.5, .damping_distance = 20.0};
  EXPECT_DOUBLE_EQ(settings.decay_rate(dx, motion_of(40.0, 0.0), 0.0), 80.0);
  EXPECT_DOUBLE_EQ(settings.decay_rate(dx, motion_of(0.0, 0.0), shear_wave_speed), 15.0);
  EXPECT_DOUBLE_EQ(settings.decay_rate(dx, motion_of(0.0, 1e-3), 0.0), 0.5);
  EXPECT_DOUBLE_EQ(settings.decay_rate(dx, motion_of(40.0, 1e-3), shear_wave_speed), 95.5);
}

TEST(Damping, AGivenTimeReplacesAllElse) {
  for (const TransferScheme scheme : {TransferScheme::moment_flip, TransferScheme::blend}) {
    const TransferSettings settings{.scheme = scheme, .damping_time = 0.25};
    EXPECT_DOUBLE_EQ(settings.decay_rate(dx, motion_of(40.0, 1e-3), shear_wave_speed), 4.0);
  }
}

TEST(Damping, TheSameTimeTakesTheSameShareInAnyNumberOfSteps) {
  for (const TransferSettings& settings : {TransferSettings{.scheme = TransferScheme::moment_flip},
                                           TransferSettings{.scheme = TransferScheme::blend, .damping_time = 0.1}}) {
    const double rate = settings.decay_rate(dx, motion_of(30.0, 0.0), shear_wave_speed);
    double share = 1.0;
    for (int step = 0; step < 8; ++step) share *= settings.kept_share(0.01, rate);
    EXPECT_NEAR(share, settings.kept_share(0.08, rate), 1e-15);
    EXPECT_LT(share, 0.9);
  }
}

TEST(Damping, SchemesOfOldKeepTheirShareWhateverTheStep) {
  const auto share = [](TransferScheme scheme) {
    return TransferSettings{.scheme = scheme, .flip_ratio = 0.75}.kept_share(0.5, 1.0);
  };
  EXPECT_EQ(share(TransferScheme::pic), 0.0);
  EXPECT_EQ(share(TransferScheme::apic), 0.0);
  EXPECT_EQ(share(TransferScheme::flip), 1.0);
  EXPECT_EQ(share(TransferScheme::blend), 0.75);
}

TEST(Damping, ShearWavesHaveTheSpeedOfTheShearModulusAtRest) {
  const double expected = std::sqrt(290.0 / 77.7);
  EXPECT_NEAR(shear_wave_speed_at_rest(HerschelBulkley{{77.7, 1e5, 290.0, 30.0, 20.0, 0.5}}), expected, 1e-7);
  EXPECT_NEAR(shear_wave_speed_at_rest(Hencky{{77.7, 1e5, 290.0}}), expected, 1e-7);
  EXPECT_NEAR(shear_wave_speed_at_rest(FixedCorotated{{77.7, 1e5, 290.0}}), expected, 1e-3);
  EXPECT_EQ(shear_wave_speed_at_rest(Newtonian{{1000.0, 1e5, 1.0}}), 0.0);
}

}  // namespace
}  // namespace bulkley::damping_test
