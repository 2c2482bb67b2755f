#include "material/laws/newtonian.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/law_samples.hpp"

namespace bulkley::newtonian_test {
namespace {

using namespace material_test;

template <class Real>
class NewtonianOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(NewtonianOf, Reals);

// Tait: p = k (J^-n - 1), k = rho_0 c_0^2 / n; tau = -p J 1 + 2 eta J dev D.
TYPED_TEST(NewtonianOf, StressOfAGeneralMotion) {
  std::mt19937_64 random(71);
  for (const double exponent : {1.0, 7.0, 3.5}) {
    const Newtonian fluid{{1000.0, 2e5, 5.0, exponent}};
    for (int i = 0; i < 100; ++i) {
      auto state = reachable_state(fluid, random, 0.1);
      const Tensor<double> L = random_tensor(random, 20.0);
      const auto update = advance<TypeParam>(fluid, state, L, 1e-3);
      const double J = state.volume_ratio;
      const double p = 2e5 / exponent * (std::pow(J, -exponent) - 1.0);
      const Eigen::Matrix3d D = 0.5 * (matrix(L) + matrix(L).transpose());
      const Eigen::Matrix3d dev_D = D - D.trace() / 3.0 * Eigen::Matrix3d::Identity();
      const Eigen::Matrix3d expected = -p * J * Eigen::Matrix3d::Identity() + 2.0 * 5.0 * J * dev_D;
      EXPECT_LT((matrix(update.kirchhoff_stress) - expected).norm(), 1e-11 * 2e5);
      EXPECT_NEAR(update.plastic_shear_rate, std::sqrt(2.0) * dev_D.norm(), 1e-12 * dev_D.norm());
      EXPECT_NEAR(update.dissipation, 10.0 * J * dev_D.squaredNorm() * 1e-3, 1e-12 * 1e2);
      EXPECT_EQ(largest_difference(state.left_cauchy_green, isochoric_identity<double>()), 0.0);
    }
  }
}

TYPED_TEST(NewtonianOf, PressureAtKnownDensities) {
  const Newtonian tait{{1000.0, 7e5, 0.0}}, linear{{1000.0, 7e5, 0.0, 1.0}};
  const auto pressure_at = [](const Newtonian& fluid, double J) {
    return of_lane(fluid.pressure(broadcast<TypeParam>(J)), 0);
  };
  EXPECT_NEAR(pressure_at(tait, 0.5), 1e5 * 127.0, 1e-7);
  EXPECT_NEAR(pressure_at(tait, 2.0), -1e5 * 127.0 / 128.0, 1e-8);
  EXPECT_NEAR(pressure_at(linear, 0.5), 7e5, 1e-8);
  EXPECT_EQ(pressure_at(tait, 1.0), 0.0);
}

TYPED_TEST(NewtonianOf, WithoutTensionOnlyCompressionIsResisted) {
  Newtonian fluid{{1000.0, 7e5, 0.0}};
  const auto pressure_at = [&](double J) { return of_lane(fluid.pressure(broadcast<TypeParam>(J)), 0); };
  const double pull = pressure_at(1.1), push = pressure_at(0.9);
  EXPECT_LT(pull, 0.0);
  fluid.parameters.tension = false;
  EXPECT_EQ(pressure_at(1.1), 0.0);
  EXPECT_EQ(pressure_at(0.9), push);
}

// c^2 = k n J^(1-n) / rho_0.
TYPED_TEST(NewtonianOf, WaveSpeed) {
  const Newtonian tait{{1000.0, 7e5, 3.0}}, linear{{1000.0, 7e5, 3.0, 1.0}};
  for (const double J : {0.5, 0.9, 1.0, 1.3}) {
    State<double> state = at_rest();
    state.volume_ratio = J;
    const auto lanes = in_every_lane<TypeParam>(state);
    EXPECT_NEAR(of_lane(tait.wave_speed_squared(lanes), 0), 700.0 * std::pow(J, -6.0), 1e-9);
    EXPECT_NEAR(of_lane(linear.wave_speed_squared(lanes), 0), 700.0, 1e-11);
  }
}

TYPED_TEST(NewtonianOf, SteadyShearHasNoNormalStressDifference) {
  const Newtonian fluid{{1000.0, 2e5, 0.7}};
  auto state = state_at_rest(fluid);
  Update<double> update{};
  for (int step = 0; step < 100; ++step) update = advance<TypeParam>(fluid, state, simple_shear(13.0), 1e-3);
  EXPECT_NEAR(update.kirchhoff_stress.c[3], 0.7 * 13.0, 1e-13);
  for (const int c : {0, 1, 2, 4, 5}) EXPECT_EQ(update.kirchhoff_stress.c[c], 0.0);
  EXPECT_NEAR(update.plastic_shear_rate, 13.0, 1e-13);
}

}  // namespace
}  // namespace bulkley::newtonian_test
