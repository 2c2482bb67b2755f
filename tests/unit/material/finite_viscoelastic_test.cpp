#include "material/laws/finite_viscoelastic.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/law_samples.hpp"

namespace bulkley::finite_viscoelastic_test {
namespace {

using namespace material_test;

template <class Real>
class FiniteViscoelasticOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(FiniteViscoelasticOf, Reals);

State<double, 6> with_branch_strain(const FiniteViscoelastic& law, double x, double y, double z) {
  auto state = state_at_rest(law);
  state.internal[0] = std::exp(2.0 * x);
  state.internal[1] = std::exp(2.0 * y);
  state.internal[2] = std::exp(2.0 * z);
  return state;
}

// mu = 1000, lambda = 1500, nu_d = 50, nu_v = 80, dt = 1e-3.
TYPED_TEST(FiniteViscoelasticOf, OneStepOfRelaxation) {
  const FiniteViscoelastic law = reference_viscoelastic();
  auto state = with_branch_strain(law, 0.1, -0.04, 0.02);
  const auto update = advance<TypeParam>(law, state, Tensor<double>{}, 1e-3);
  const double expected[] = {0.095809263201, -0.038806121415, 0.018886186277};
  const double trace = expected[0] + expected[1] + expected[2];
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(0.5 * std::log(state.internal[k]), expected[k], 1e-12);
    EXPECT_NEAR(state.internal[3 + k], 0.0, 1e-15);
    EXPECT_NEAR(update.kirchhoff_stress.c[k], 2.0 * 1000.0 * expected[k] + 1500.0 * trace, 1e-8);
  }
}

// The same in axes that are not those of the grid.
TYPED_TEST(FiniteViscoelasticOf, OneStepOfRelaxationInTurnedAxes) {
  const FiniteViscoelastic law = reference_viscoelastic();
  std::mt19937_64 random(73);
  for (int i = 0; i < 20; ++i) {
    const Tensor<double> Q = tensor(random_rotation(random));
    auto state = rotated(law, with_branch_strain(law, 0.1, -0.04, 0.02), Q);
    advance<TypeParam>(law, state, Tensor<double>{}, 1e-3);
    const auto expected = rotated(law, with_branch_strain(law, 0.095809263201, -0.038806121415, 0.018886186277), Q);
    for (int c = 0; c < 6; ++c) EXPECT_NEAR(state.internal[c], expected.internal[c], 3e-12);
  }
}

// Deviator and volume each decay in their own time, to first order in dt; the elastic branch stays.
TYPED_TEST(FiniteViscoelasticOf, RelaxationConvergesToExponentials) {
  const FiniteViscoelastic law = reference_viscoelastic();
  const double time = 0.02, t_s = law.parameters.relaxation_time, t_v = law.parameters.bulk_relaxation_time;
  double error[3][2];
  for (int level = 0; level < 3; ++level) {
    const int n_steps = 50 << level;
    auto state = with_branch_strain(law, 0.1, -0.04, 0.02);
    for (int step = 0; step < n_steps; ++step) advance<TypeParam>(law, state, Tensor<double>{}, time / n_steps);
    double strain[3];
    for (int k = 0; k < 3; ++k) strain[k] = 0.5 * std::log(state.internal[k]);
    const double volume = strain[0] + strain[1] + strain[2];
    error[level][0] = std::fabs(strain[0] - volume / 3.0 - (0.1 - 0.08 / 3.0) * std::exp(-time / t_s));
    error[level][1] = std::fabs(volume - 0.08 * std::exp(-time / t_v));
  }
  for (int level = 1; level < 3; ++level)
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(error[level - 1][k] / error[level][k]), 1.0, 0.05);
  EXPECT_LT(error[2][0], 1e-4);
  EXPECT_LT(error[2][1], 1e-4);
}

// At once both branches resist; in the end the elastic one alone.
TYPED_TEST(FiniteViscoelasticOf, FromInstantaneousToEquilibriumStress) {
  const FiniteViscoelastic law = reference_viscoelastic();
  const Tensor<double> L{{0.1, 0.2, 0, 0, -0.05, 0.1, 0, 0, 0.02}};
  auto state = state_at_rest(law);
  const auto first = advance<TypeParam>(law, state, L, 1.0 /* s: equilibrium, but for dt / t_s */);
  auto elastic = state_at_rest(law.elastic()), instant = elastic;
  const auto neo_hookean = law.elastic().update(elastic, L, 1.0).kirchhoff_stress;
  EXPECT_GT(largest_difference(first.kirchhoff_stress, neo_hookean), 1.0);
  for (int step = 0; step < 20; ++step) advance<TypeParam>(law, state, Tensor<double>{}, 1.0);
  EXPECT_LT(largest_difference(law.kirchhoff_stress(state), neo_hookean), 1e-9);

  auto sudden = state_at_rest(law);
  Tensor<double> fast = L;
  for (double& c : fast.c) c *= 1e9;
  const auto tau = advance<TypeParam>(law, sudden, fast, 1e-9).kirchhoff_stress;
  const auto hencky = law.branch().update(instant, fast, 1e-9).kirchhoff_stress;
  for (int c = 0; c < 6; ++c) EXPECT_NEAR(tau.c[c], neo_hookean.c[c] + hencky.c[c], 1e-4);
}

// Backward Euler loses what is dissipated and, of second order in dt, a little more.
TYPED_TEST(FiniteViscoelasticOf, DissipationIsWhatTheEnergyLoses) {
  const FiniteViscoelastic law = reference_viscoelastic();
  for (const double dt : {1e-4, 1e-5}) {
    auto state = with_branch_strain(law, 0.1, -0.04, 0.02);
    const double before = law.energy_density(state);
    const auto update = advance<TypeParam>(law, state, Tensor<double>{}, dt);
    const double lost = before - law.energy_density(state);
    EXPECT_GT(update.dissipation, 0.0);
    EXPECT_LE(update.dissipation, lost);
    EXPECT_NEAR(update.dissipation, lost, 1.2 * dt / law.parameters.bulk_relaxation_time * lost);
  }
}

TYPED_TEST(FiniteViscoelasticOf, WithoutBulkRelaxationTheBranchKeepsItsVolume) {
  FiniteViscoelastic law = reference_viscoelastic();
  law.parameters.bulk_relaxation_time = std::numeric_limits<double>::infinity();
  auto state = with_branch_strain(law, 0.1, -0.04, 0.02);
  for (int step = 0; step < 1000; ++step) advance<TypeParam>(law, state, Tensor<double>{}, 1e-3);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(0.5 * std::log(state.internal[k]), 0.08 / 3.0, 1e-12);
}

}  // namespace
}  // namespace bulkley::finite_viscoelastic_test
