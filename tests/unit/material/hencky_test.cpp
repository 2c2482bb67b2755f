// Reference: the logarithmic strain by Eigen's singular values.

#include "material/laws/hencky.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/law_samples.hpp"

namespace bulkley::hencky_test {
namespace {

using namespace material_test;

const Hencky solid{{1100.0, 1e5, 2.5e4}};
constexpr double lambda = 1e5 - 2.0 / 3.0 * 2.5e4;

template <class Real>
class HenckyOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(HenckyOf, Reals);

// tau = U (2 mu ln S + lambda tr ln S) U^T with F = U S V^T.
TYPED_TEST(HenckyOf, StressIsThatOfTheLogarithmicStrain) {
  std::mt19937_64 random(61);
  for (int i = 0; i < 300; ++i) {
    Tensor<double> L = random_tensor(random, 0.3);
    const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + matrix(L);
    if (F.determinant() < 0.1) continue;
    auto state = state_at_rest(solid);
    const auto tau = advance<TypeParam>(solid, state, L, 1.0).kirchhoff_stress;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Vector3d strain = svd.singularValues().array().log();
    const Eigen::Vector3d values = 2.0 * 2.5e4 * strain.array() + lambda * strain.sum();
    const Eigen::Matrix3d expected = svd.matrixU() * values.asDiagonal() * svd.matrixU().transpose();
    EXPECT_LT((matrix(tau) - expected).norm(), 1e-11 * 1e5) << i;
  }
}

TYPED_TEST(HenckyOf, KnownStretches) {
  auto state = stretched(solid, std::exp(0.3), std::exp(-0.1), std::exp(0.05));
  const auto tau = advance<TypeParam>(solid, state, Tensor<double>{}, 1.0).kirchhoff_stress;
  const double expected[] = {5e4 * 0.3 + lambda * 0.25, -5e4 * 0.1 + lambda * 0.25, 5e4 * 0.05 + lambda * 0.25, 0, 0, 0};
  for (int c = 0; c < 6; ++c) EXPECT_NEAR(tau.c[c], expected[c], 1e-8);
  const double energy = 2.5e4 * (0.09 + 0.01 + 0.0025) + 0.5 * lambda * 0.0625;
  EXPECT_NEAR(solid.energy_density(state), energy, 1e-9);
}

TYPED_TEST(HenckyOf, SmallStrainIsLinearElasticity) {
  std::mt19937_64 random(62);
  for (const double size : {1e-4, 1e-6}) {
    const Tensor<double> L = random_tensor(random, size);
    auto state = state_at_rest(solid);
    const auto tau = advance<TypeParam>(solid, state, L, 1.0).kirchhoff_stress;
    const SymTensor<double> linear = linear_elasticity(1e5, 2.5e4, L);
    EXPECT_LT(largest_difference(tau, linear), 10.0 * size * largest_component(linear));
  }
}

TEST(Hencky, WaveSpeedAtRestIsThatOfLinearElasticity) {
  const double expected = (1e5 + 4.0 / 3.0 * 2.5e4) / 1100.0;
  EXPECT_NEAR(solid.wave_speed_squared(state_at_rest(solid)), expected, 1e-14 * expected);
}

// rho_0 c^2 = J dp/dJ by ln J: under pressure alone kappa (1 - ln J) + (4/3) mu.
TEST(Hencky, WaveSpeedUnderPressure) {
  const double stretch = std::cbrt(0.6);
  const double expected = (1e5 * (1.0 - std::log(0.6)) + 4.0 / 3.0 * 2.5e4) / 1100.0;
  EXPECT_NEAR(solid.wave_speed_squared(stretched(solid, stretch, stretch, stretch)), expected, 1e-12 * expected);
}

}  // namespace
}  // namespace bulkley::hencky_test
