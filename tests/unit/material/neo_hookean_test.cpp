#include "material/laws/neo_hookean.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "support/random_vectors.hpp"
#include "support.hpp"

namespace bulkley::neo_hookean_test {
namespace {

using namespace material_test;

const NeoHookean solid{{1100.0, 1e5, 2.5e4}};

TEST(NeoHookean, SmallStrainIsLinearElasticity) {
  std::mt19937_64 random(1);
  for (const double size : {1e-4, 1e-6}) {
    const Tensor<double> L = random_tensor(random, size);
    State<double> state = at_rest();
    const SymTensor<double> tau = solid.update(state, L, 1.0).kirchhoff_stress;
    const double volume = L(0, 0) + L(1, 1) + L(2, 2);
    SymTensor<double> linear;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j)
        linear.c[symmetric_index(i, j)] =
            solid.parameters.shear_modulus * (L(i, j) + L(j, i)) +
            (i == j ? (solid.parameters.bulk_modulus - 2.0 / 3.0 * solid.parameters.shear_modulus) * volume : 0.0);
    EXPECT_LT(largest_difference(tau, linear), 10.0 * size * largest_component(linear));
  }
}

TEST(NeoHookean, DeterminantOfBStaysOne) {
  std::mt19937_64 random(2);
  for (const double strain : {1e-9, 1e-3, 0.1, 0.5}) {
    for (int i = 0; i < 200; ++i) EXPECT_NEAR(determinant(random_state(random, strain).left_cauchy_green), 1.0, 1e-12);
  }
}

// Rounding must not accumulate faster than the number of steps.
TEST(NeoHookean, DeterminantOfBStaysOneOverManySteps) {
  std::mt19937_64 random(3);
  State<double> state = at_rest();
  constexpr int n_steps = 100000;
  const Tensor<double> there = random_tensor(random, 1.0);
  for (int step = 0; step < n_steps; ++step) {
    Tensor<double> L = there;
    for (double& c : L.c) c *= std::cos(2.0 * M_PI * step / 1000.0);
    solid.update(state, L, 1e-3);
  }
  EXPECT_NEAR(determinant(state.left_cauchy_green), 1.0, n_steps * 4e-16);
}

TEST(NeoHookean, VolumeRatioFollowsTheDeterminant) {
  State<double> state = at_rest();
  const auto result = solid.update(state, Tensor<double>{{-5, 0, 0, 0, -5, 0, 0, 0, -5}}, 1e-3);
  EXPECT_NEAR(state.volume_ratio, 0.985074875, 1e-15);
  const double expected = 0.5 * solid.parameters.bulk_modulus * (0.985074875 * 0.985074875 - 1.0);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(result.kirchhoff_stress.c[a], expected, 1e-12 * std::fabs(expected));
}

// dW/dt = tau : D along any motion.
TEST(NeoHookean, StressIsTheDerivativeOfTheEnergy) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 500; ++i) {
    const State<double> state = random_state(random, 0.4);
    const Tensor<double> L = random_tensor(random, 1.0);
    constexpr double step = 1e-5;
    State<double> after = state, before = state;
    deform(after, L, step);
    deform(before, L, -step);
    const double power = (solid.energy_density(after) - solid.energy_density(before)) / (2.0 * step);
    const SymTensor<double> tau = solid.kirchhoff_stress(state);
    EXPECT_NEAR(power, contract(tau, L), 1e-7 * (norm(tau) + solid.parameters.bulk_modulus) * 10.0);
  }
}

TEST(NeoHookean, EnergyIsZeroAtRestAndPositiveElsewhere) {
  EXPECT_EQ(solid.energy_density(at_rest()), 0.0);
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) EXPECT_GT(solid.energy_density(random_state(random, 0.1)), 0.0);
}

// --- wave speed ---------------------------------------------------------------------------------------------------------

// Squared speed of the fastest plane wave in direction n: a wave displaces by m phi(n.x - ct), so
// rho_0 c^2 = d^2/de^2 W((1 + e m n^T) F), a quadratic form in m; its matrix from finite differences of the energy.
double fastest_wave(const NeoHookean& law, const State<double>& state, const Eigen::Vector3d& n) {
  const auto curvature = [&](const Eigen::Vector3d& m) {
    constexpr double step = 1e-3;
    const auto energy = [&](double e) {
      State<double> moved = state;
      Tensor<double> L;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) L(i, j) = m[i] * n[j];
      deform(moved, L, e);
      return law.energy_density(moved);
    };
    return (-energy(2 * step) + 16 * energy(step) - 30 * energy(0.0) + 16 * energy(-step) - energy(-2 * step)) /
           (12 * step * step);
  };
  Eigen::Matrix3d acoustic;
  for (int i = 0; i < 3; ++i) acoustic(i, i) = curvature(Eigen::Vector3d::Unit(i));
  for (int i = 0; i < 3; ++i)
    for (int j = i + 1; j < 3; ++j)
      acoustic(i, j) = acoustic(j, i) =
          0.5 * (curvature(Eigen::Vector3d::Unit(i) + Eigen::Vector3d::Unit(j)) - acoustic(i, i) - acoustic(j, j));
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(acoustic).eigenvalues().maxCoeff() / law.density();
}

class WaveSpeed : public testing::TestWithParam<double> {};

TEST_P(WaveSpeed, BoundsEveryPlaneWaveAndIsNotLax) {
  NeoHookean law = solid;
  law.parameters.bulk_modulus = GetParam() * law.parameters.shear_modulus;
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal(0.0, 1.0);
  double largest_ratio = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const State<double> state = random_state(random, 0.5);
    Eigen::Vector3d n = random_vector(normal, random);
    if (i % 2 == 0) {  // a principal direction: fastest there
      Eigen::Matrix3d b;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) b(r, c) = state.left_cauchy_green(r, c);
      n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(b).eigenvectors().col(i / 2 % 3);
    }
    n.normalize();
    const double ratio = fastest_wave(law, state, n) / law.wave_speed_squared(state);
    EXPECT_LE(ratio, 1.0 + 1e-6);
    largest_ratio = std::max(largest_ratio, ratio);
  }
  EXPECT_GE(largest_ratio, 0.9);
}

INSTANTIATE_TEST_SUITE_P(BulkOverShear, WaveSpeed, testing::Values(0.7, 4.0, 100.0));

TEST(WaveSpeed, AtRestIsThatOfLinearElasticity) {
  const NeoHookean::Parameters& p = solid.parameters;
  const double expected = (p.bulk_modulus + 4.0 / 3.0 * p.shear_modulus) / p.density;
  EXPECT_NEAR(solid.wave_speed_squared(at_rest()), expected, 1e-14 * expected);
  EXPECT_NEAR(fastest_wave(solid, at_rest(), Eigen::Vector3d::UnitX()), expected, 1e-7 * expected);
}

// The largest eigenvalue's bound is sharp for one large and two equal small ones.
TEST(WaveSpeed, UniaxialStretchUsesTheLargestEigenvalueItself) {
  const State<double> state{{{4.0, 0.5, 0.5, 0, 0, 0}}, 1.1};
  const NeoHookean::Parameters& p = solid.parameters;
  const double expected = (0.5 * p.bulk_modulus * (1.1 * 1.1 + 1.0) + 4.0 / 3.0 * p.shear_modulus * 4.0) / p.density;
  EXPECT_NEAR(solid.wave_speed_squared(state), expected, 1e-14 * expected);
}

// --- no shear stiffness
// -----------------------------------------------------------------------------------------------------

TEST(NeoHookean, WithoutShearStiffnessKeepsBAtRest) {
  const NeoHookean fluid{{1000.0, 1e5, 0.0}};
  std::mt19937_64 random(8);
  State<double> state = at_rest();
  for (int step = 0; step < 20; ++step) fluid.update(state, random_tensor(random, 1.0), 0.1);
  EXPECT_EQ(largest_difference(state.left_cauchy_green, isochoric_identity<double>()), 0.0);
  EXPECT_NE(state.volume_ratio, 1.0);
}

}  // namespace
}  // namespace bulkley::neo_hookean_test
