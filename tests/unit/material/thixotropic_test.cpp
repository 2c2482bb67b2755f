#include "material/laws/thixotropic.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/law_samples.hpp"

namespace bulkley::thixotropic_test {
namespace {

using namespace material_test;
using Thixotropic = ThixotropicHerschelBulkley;

template <class Real>
class ThixotropicOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(ThixotropicOf, Reals);

// t_eq = 10 s, a = c = 1; tau_y = 10 Pa, K = 5 Pa s^0.5, eta_inf = 0.1 Pa s; stiff, so that elastic strain is below 1e-4.
Thixotropic reference_fluid() {
  Thixotropic::Parameters p{{1000.0, 1e7, 1e6}};
  set_flow(p, {10.0, 5.0, 0.5});
  p.background_viscosity = 0.1;
  p.build_up = 0.1;
  p.breakdown = 0.1;
  return {p};
}

template <class Real>
double next(const Thixotropic& law, double structure, double rate, double dt) {
  return of_lane(law.next_structure(broadcast<Real>(structure), broadcast<Real>(rate), dt), n_lanes - 1);
}

TYPED_TEST(ThixotropicOf, StructureOverTime) {
  const Thixotropic law = reference_fluid();
  EXPECT_NEAR(next<TypeParam>(law, 1.0, 2.0, 5.0), 0.482086773432, 1e-12);
  EXPECT_NEAR(next<TypeParam>(law, 1.0, 2.0, 20.0), 0.334985834784, 1e-12);
  EXPECT_NEAR(next<TypeParam>(law, 1.0, 2.0, 1e6), 1.0 / 3.0, 1e-15);
  EXPECT_NEAR(next<TypeParam>(law, 1.0 / 3.0, 0.0, 10.0), 0.754747039219, 1e-12);
}

// Exact at a constant rate: many steps give what one gives.
TYPED_TEST(ThixotropicOf, StructureDoesNotDependOnTheStep) {
  for (Thixotropic law : {reference_fluid(), rheopectic_fluid()})
    for (const double exponent : {1.0, 0.6, 2.0}) {
      law.parameters.rate_exponent = exponent;
      double structure = 0.7;
      for (int step = 0; step < 64; ++step) structure = next<TypeParam>(law, structure, 3.0, 1.0 / 64.0);
      EXPECT_NEAR(structure, next<TypeParam>(law, 0.7, 3.0, 1.0), 1e-13);
    }
}

// Rheopectic: lambda' = k_b rate^c (1 - lambda) - k_d lambda.
TYPED_TEST(ThixotropicOf, RheopecticStructureBuildsUpUnderShear) {
  const Thixotropic law = rheopectic_fluid();
  const double build = 0.3 * std::pow(4.0, 1.3), sum = build + 2.0;
  const double expected = build / sum + (0.2 - build / sum) * std::exp(-sum * 0.7);
  EXPECT_NEAR(next<TypeParam>(law, 0.2, 4.0, 0.7), expected, 1e-14);
  EXPECT_NEAR(next<TypeParam>(law, 0.2, 0.0, 0.7), 0.2 * std::exp(-1.4), 1e-14);
}

TYPED_TEST(ThixotropicOf, StructureStaysBetweenZeroAndOne) {
  std::mt19937_64 random(74);
  std::uniform_real_distribution<double> fraction(0.0, 1.0), exponent(-12.0, 12.0);
  for (const Thixotropic& law : {reference_fluid(), rheopectic_fluid(), unstructured_fluid()})
    for (int i = 0; i < 3000; ++i) {
      const double start = i % 10 == 0 ? 0.0 : i % 10 == 1 ? 1.0 : fraction(random);
      const double after = next<TypeParam>(law, start, std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random)));
      EXPECT_GE(after, 0.0);
      EXPECT_LE(after, 1.0 + 1e-15);
    }
}

// tau = tau_y l + K l rate^n + eta_inf rate with l = 1 / (1 + rate): falls, then rises.
TYPED_TEST(ThixotropicOf, SteadyFlowCurve) {
  const Thixotropic law = reference_fluid();
  const double rates[] = {0.01, 0.1, 1.0, 10.0, 100.0};
  const double stresses[] = {10.3970396, 10.53830803, 7.6, 3.346489846, 10.59405941};
  for (int i = 0; i < 5; ++i) {
    const double rate = rates[i], dt = std::min(1e-3 / rate, 0.02);
    auto state = state_at_rest(law);
    state.internal[0] = i % 2 == 0 ? 1.0 : 0.0;
    const double time = 25.0 / (0.1 * (1.0 + rate)) + 1e-3 / rate;
    Update<double> update{};
    for (double t = 0.0; t < time; t += dt) update = advance<TypeParam>(law, state, simple_shear(rate), dt);
    EXPECT_NEAR(state.internal[0], 1.0 / (1.0 + rate), 1e-6) << rate;
    EXPECT_NEAR(update.kirchhoff_stress.c[3], stresses[i], 2e-6 * stresses[i]) << rate;
    EXPECT_NEAR(update.plastic_shear_rate, rate, 1e-5 * rate);
  }
}

// Without kinetics it is Herschel-Bulkley with the strength of its structure.
TYPED_TEST(ThixotropicOf, WithFixedStructureItIsHerschelBulkley) {
  std::mt19937_64 random(75);
  for (const double structure : {1.0, 0.37, 1e-3, 0.0}) {
    Thixotropic::Parameters p{with_background(foam().parameters, 0.3)};
    p.build_up = p.breakdown = 0.0;
    p.yield_exponent = 1.7;
    p.consistency_exponent = 0.4;
    p.residual_yield = 0.2;
    p.residual_consistency = 0.1;
    p.initial_structure = structure;
    const Thixotropic law{p};
    HerschelBulkley::Parameters fixed = p;
    fixed.sigma_Y *= 0.2 + 0.8 * std::pow(structure, 1.7);
    fixed.eta *= 0.1 + 0.9 * std::pow(structure, 0.4);
    const HerschelBulkley same{fixed};
    auto state = state_at_rest(law);
    auto expected_state = state_at_rest(same);
    for (int step = 0; step < 300; ++step) {
      const Tensor<double> L = random_tensor(random, 30.0);
      const auto update = advance<TypeParam>(law, state, L, 1e-3);
      const auto expected = same.update(expected_state, L, 1e-3);
      EXPECT_LT(largest_difference(state.left_cauchy_green, expected_state.left_cauchy_green), 1e-12);
      EXPECT_LT(largest_difference(update.kirchhoff_stress, expected.kirchhoff_stress), 1e-12 * 109000.0);
      EXPECT_NEAR(update.plastic_shear_rate, expected.plastic_shear_rate, 1e-9 * (1.0 + expected.plastic_shear_rate));
      EXPECT_EQ(state.internal[0], structure);
    }
  }
}

TYPED_TEST(ThixotropicOf, ExponentZeroLeavesTheFlowAlone) {
  Thixotropic::Parameters p{foam().parameters};
  p.build_up = p.breakdown = 1.0;
  p.yield_exponent = p.consistency_exponent = 0.0;
  p.initial_structure = 0.0;
  const Thixotropic law{p};
  auto state = state_at_rest(law);
  auto expected_state = at_rest();
  for (int step = 0; step < 100; ++step) {
    const auto update = advance<TypeParam>(law, state, simple_shear(20.0), 1e-3);
    const auto expected = foam().update(expected_state, simple_shear(20.0), 1e-3);
    EXPECT_LT(largest_difference(update.kirchhoff_stress, expected.kirchhoff_stress), 1e-10);
  }
  EXPECT_GT(state.internal[0], 0.0);
}

// Nothing resists where all strength goes with the structure and there is none left.
TYPED_TEST(ThixotropicOf, WithoutStructureAndResidualsThereIsNoShearStress) {
  Thixotropic law = unstructured_fluid();
  law.parameters.build_up = 0.0;
  auto state = state_at_rest(law);
  for (int step = 0; step < 20; ++step) {
    const auto update = advance<TypeParam>(law, state, simple_shear(20.0), 1e-3);
    EXPECT_LT(norm(deviator(update.kirchhoff_stress)), 1e-12);
    EXPECT_NEAR(update.plastic_shear_rate, 20.0, 0.01 * 20.0);
    EXPECT_EQ(state.internal[0], 0.0);
  }
}

}  // namespace
}  // namespace bulkley::thixotropic_test
