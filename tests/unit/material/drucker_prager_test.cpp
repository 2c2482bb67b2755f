#include "material/laws/drucker_prager.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/law_samples.hpp"

namespace bulkley::drucker_prager_test {
namespace {

using namespace material_test;

constexpr double mu = 136038.46153846153, lambda = 204057.69230769231, kappa = lambda + 2.0 / 3.0 * mu;

template <class Real>
class DruckerPragerOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(DruckerPragerOf, Reals);

struct Outcome {
  double strain[3], plastic_strain;
  Update<double> update;
};

// A trial with these principal logarithmic strains, returned to the cone; the elastic strain from the stress.
template <class Real>
Outcome returned(const DruckerPrager& law, double x, double y, double z, double hardening = 0.0) {
  auto state = stretched(law, std::exp(x), std::exp(y), std::exp(z));
  state.internal[0] = hardening;
  Outcome out{};
  out.update = advance<Real>(law, state, Tensor<double>{}, 1e-3);
  const SymTensor<double>& tau = out.update.kirchhoff_stress;
  for (int k = 0; k < 3; ++k) out.strain[k] = (tau.c[k] - lambda * trace(tau) / (3.0 * kappa)) / (2.0 * mu);
  out.plastic_strain = state.internal[0] - hardening;
  return out;
}

TYPED_TEST(DruckerPragerOf, ReturnsOfTheReference) {
  const DruckerPrager sand = reference_sand(30.0);
  const Outcome sliding = returned<TypeParam>(sand, -0.02, 0.006, 0.004);
  const double expected[] = {-0.011979274582, 0.001508393766, 0.000470880816};
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(sliding.strain[k], expected[k], 1e-12);
  EXPECT_NEAR(sliding.plastic_strain, 0.0098468901189, 1e-13);
  EXPECT_NEAR(sliding.update.plastic_shear_rate, std::sqrt(2.0) * 0.0098468901189 / 1e-3, 1e-9);

  const Outcome pressed = returned<TypeParam>(sand, -0.02, -0.02, -0.02);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(pressed.update.kirchhoff_stress.c[k], -17685.0, 1e-8);
  EXPECT_NEAR(pressed.plastic_strain, 0.0, 1e-15);

  const Outcome torn = returned<TypeParam>(sand, 0.01, -0.001, 0.002);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(torn.update.kirchhoff_stress.c[k], 0.0, 1e-9);

  const Outcome kept = returned<TypeParam>(sand, -0.01, 0.002, -0.001);
  const double same[] = {-0.01, 0.002, -0.001};
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(kept.strain[k], same[k], 1e-15);
  EXPECT_EQ(kept.plastic_strain, 0.0);
}

TEST(DruckerPrager, ConeSlopes) {
  const double angles[] = {20.0, 30.0, 35.0, 40.0}, slopes[] = {0.2101282122, 0.3265986324, 0.38601933, 0.445300464};
  const double digits[] = {1e-10, 1e-10, 1e-8, 1e-9};  // as the table has them
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(reference_sand(angles[i]).cone_slope_at_rest(), slopes[i], digits[i]);
    EXPECT_NEAR(reference_sand(angles[i]).cone_slope_after(3.0), slopes[i], digits[i]);
  }
}

// The cone goes through Mohr and Coulomb's edge of triaxial compression: (1 + sin phi) / (1 - sin phi) between the stresses.
TYPED_TEST(DruckerPragerOf, StressRatioInTriaxialCompression) {
  for (const double angle : {20.0, 35.0}) {
    const Outcome out = returned<TypeParam>(reference_sand(angle), -0.05, 0.01, 0.01);
    const double s = std::sin(angle * M_PI / 180.0);
    EXPECT_NEAR(out.update.kirchhoff_stress.c[0] / out.update.kirchhoff_stress.c[1], (1.0 + s) / (1.0 - s), 1e-10);
  }
}

// Grains that came apart must close the gap before they resist again, and then do so elastically.
TYPED_TEST(DruckerPragerOf, VolumeIsRecoveredBeforeItResists) {
  const DruckerPrager sand = reference_sand();
  auto state = state_at_rest(sand);
  advance<TypeParam>(sand, state, Tensor<double>{{0.02, 0.3, 0, 0, 0.03, 0, 0.1, 0, 0.01}}, 1.0);  // torn and sheared
  EXPECT_LT(norm(sand.kirchhoff_stress(state)), 1e-9);
  while (state.volume_ratio > 1.0) {
    EXPECT_LT(norm(sand.kirchhoff_stress(state)), 1e-9);
    advance<TypeParam>(sand, state, diagonal(-1.0, -1.0, -1.0), 1e-3);
  }
  for (int step = 0; step < 20; ++step) {
    const auto tau = advance<TypeParam>(sand, state, diagonal(-1.0, -1.0, -1.0), 1e-3).kirchhoff_stress;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(tau.c[k], kappa * std::log(state.volume_ratio), 1e-8);
  }
}

TYPED_TEST(DruckerPragerOf, HydrostaticCompressionIsElastic) {
  const DruckerPrager sand = reference_sand();
  auto state = state_at_rest(sand);
  const double there = 0.01, back = -there / (1.0 + there);
  for (int step = 0; step < 30; ++step) {
    const auto update = advance<TypeParam>(sand, state, diagonal(back, back, back), 1.0);
    EXPECT_NEAR(update.dissipation, 0.0, 1e-12);
  }
  EXPECT_NEAR(trace(sand.kirchhoff_stress(state)), -9.0 * kappa * 30 * std::log(1.01), 1e-6);
  for (int step = 0; step < 30; ++step) advance<TypeParam>(sand, state, diagonal(there, there, there), 1.0);
  EXPECT_NEAR(state.volume_ratio, 1.0, 1e-13);
  EXPECT_LT(norm(sand.kirchhoff_stress(state)), 1e-7);
  EXPECT_NEAR(state.internal[0], 0.0, 1e-12);
}

// Under cohesion c: isotropic tension up to c / tan phi; without pressure a deviator of
// sqrt(2/3) 6 c cos phi / (3 - sin phi).
TYPED_TEST(DruckerPragerOf, Cohesion) {
  const DruckerPrager sand = cohesive_sand();
  const double phi = 25.0 * M_PI / 180.0, c = 2000.0;
  const Outcome torn = returned<TypeParam>(sand, 0.1, 0.2, 0.15);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(torn.update.kirchhoff_stress.c[k], c / std::tan(phi), 1e-8);
  const Outcome sheared = returned<TypeParam>(sand, 0.1, -0.1, 0.0);
  EXPECT_NEAR(norm(sheared.update.kirchhoff_stress), std::sqrt(2.0 / 3.0) * 6.0 * c * std::cos(phi) / (3.0 - std::sin(phi)),
              1e-8);
  const Outcome pulled = returned<TypeParam>(sand, 0.001, 0.001, 0.001);  // below the tip: elastic
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(pulled.update.kirchhoff_stress.c[k], kappa * 0.003, 1e-8);
  EXPECT_NEAR(pulled.plastic_strain, 0.0, 1e-15);
}

// phi = h0 + (h1 q - h3) exp(-h2 q), degrees.
TYPED_TEST(DruckerPragerOf, Hardening) {
  const DruckerPrager sand = hardening_sand();
  for (const double q : {0.0, 0.01, 0.5, 3.0, 50.0}) {
    const double phi = (35.0 + (9.0 * q - 10.0) * std::exp(-0.2 * q)) * M_PI / 180.0;
    const double expected = std::sqrt(2.0 / 3.0) * 2.0 * std::sin(phi) / (3.0 - std::sin(phi));
    EXPECT_NEAR(of_lane(sand.cone_slope_after(broadcast<TypeParam>(q)), 0), expected, 1e-14) << q;
    const Outcome out = returned<TypeParam>(sand, -0.05, 0.01, 0.01, q);
    const double s = std::sin(phi);
    EXPECT_NEAR(out.update.kirchhoff_stress.c[0] / out.update.kirchhoff_stress.c[1], (1.0 + s) / (1.0 - s), 1e-10) << q;
  }
}

// The deviator shrinks by one factor, at constant volume; the energy lost is quadratic in it, and at the stress of the end it
// is dissipated.
TYPED_TEST(DruckerPragerOf, SlidingKeepsTheVolumeAndTheDirection) {
  std::mt19937_64 random(76);
  int n_sliding = 0;
  for (int i = 0; i < 600; ++i) {
    const DruckerPrager sand = i % 2 == 0 ? reference_sand() : cohesive_sand();
    auto state = reachable_state(sand, random, 0.02);
    auto trial = state;
    const Tensor<double> L = random_tensor(random, 0.02);
    deform(static_cast<State<double>&>(trial), L, 1.0);
    const auto trial_tau = sand.elastic().kirchhoff_stress(static_cast<const State<double>&>(trial));
    const double trial_energy = sand.energy_density(trial);
    const auto update = advance<TypeParam>(sand, state, L, 1.0);
    const auto trial_strain = log_strain(trial.left_cauchy_green), strain = log_strain(state.left_cauchy_green);
    const double kept = std::sqrt(strain.norm_squared()), taken = std::sqrt(trial_strain.norm_squared()) - kept;
    const double stiffness = sand.parameters.shear_modulus;
    EXPECT_NEAR(update.dissipation, 2.0 * stiffness * kept * taken, 1e-9);
    EXPECT_NEAR(trial_energy - sand.energy_density(state), update.dissipation + stiffness * taken * taken, 1e-9);
    if (update.plastic_shear_rate == 0.0 || state.volume_ratio > 0.999) continue;
    ++n_sliding;
    EXPECT_NEAR(trace(update.kirchhoff_stress), trace(trial_tau), 1e-8);
    const auto s = deviator(update.kirchhoff_stress), s_trial = deviator(trial_tau);
    for (int c = 0; c < 6; ++c)
      EXPECT_NEAR(s.c[c] * norm(s_trial), s_trial.c[c] * norm(s), 1e-9 * norm(s_trial) * norm(s_trial));
  }
  EXPECT_GT(n_sliding, 30);
}

}  // namespace
}  // namespace bulkley::drucker_prager_test
