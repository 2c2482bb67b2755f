// Reference: the polar decomposition by Eigen's singular values.

#include "material/laws/fixed_corotated.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/law_samples.hpp"

namespace bulkley::fixed_corotated_test {
namespace {

using namespace material_test;

const FixedCorotated solid{{1100.0, 1e5, 2.5e4}};
constexpr double lambda = 1e5 - 2.0 / 3.0 * 2.5e4;

template <class Real>
class FixedCorotatedOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(FixedCorotatedOf, Reals);

// tau = 2 mu (F - R) F^T + lambda J (J - 1) 1, W = mu ||F - R||^2 + (lambda/2) (J - 1)^2.
TYPED_TEST(FixedCorotatedOf, StressAndEnergyAreThoseOfThePolarDecomposition) {
  std::mt19937_64 random(63);
  for (int i = 0; i < 300; ++i) {
    Tensor<double> L = random_tensor(random, 0.3);
    const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + matrix(L);
    const double J = F.determinant();
    if (J < 0.1) continue;
    auto state = state_at_rest(solid);
    const auto tau = advance<TypeParam>(solid, state, L, 1.0).kirchhoff_stress;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
    const Eigen::Matrix3d expected = 5e4 * (F - R) * F.transpose() + lambda * J * (J - 1.0) * Eigen::Matrix3d::Identity();
    EXPECT_LT((matrix(tau) - expected).norm(), 1e-11 * 1e5) << i;
    const double energy = 2.5e4 * (F - R).squaredNorm() + 0.5 * lambda * (J - 1.0) * (J - 1.0);
    EXPECT_NEAR(solid.energy_density(state), energy, 1e-11 * 1e5);
  }
}

TYPED_TEST(FixedCorotatedOf, SmallStrainIsLinearElasticity) {
  std::mt19937_64 random(64);
  for (const double size : {1e-4, 1e-6}) {
    const Tensor<double> L = random_tensor(random, size);
    auto state = state_at_rest(solid);
    const auto tau = advance<TypeParam>(solid, state, L, 1.0).kirchhoff_stress;
    const SymTensor<double> linear = linear_elasticity(1e5, 2.5e4, L);
    EXPECT_LT(largest_difference(tau, linear), 10.0 * size * largest_component(linear));
  }
}

TEST(FixedCorotated, WaveSpeedAtRestIsThatOfLinearElasticity) {
  const double expected = (1e5 + 4.0 / 3.0 * 2.5e4) / 1100.0;
  EXPECT_NEAR(solid.wave_speed_squared(state_at_rest(solid)), expected, 1e-14 * expected);
}

}  // namespace
}  // namespace bulkley::fixed_corotated_test
