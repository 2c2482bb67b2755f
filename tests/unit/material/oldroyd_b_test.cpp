// Steady and start-up shear, against the solutions of the upper-convected Maxwell model.

#include "material/laws/oldroyd_b.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/law_samples.hpp"

namespace bulkley::oldroyd_b_test {
namespace {

using namespace material_test;

constexpr double G = 400.0, relaxation_time = 0.05, solvent = 3.0;

OldroydB fluid(OldroydB::Form form, double solvent_viscosity = 0.0) {
  return {{1000.0, 1e5, G, relaxation_time, solvent_viscosity, form}};
}

struct Shear {
  double shear_stress, normal_stress, rate;
};
template <class Real>
Shear shear(const OldroydB& law, double rate, double time, double dt) {
  auto state = state_at_rest(law);
  Update<double> update{};
  for (int step = 0, n = static_cast<int>(std::lround(time / dt)); step < n; ++step)
    update = advance<Real>(law, state, simple_shear(rate), dt);
  const SymTensor<double>& tau = update.kirchhoff_stress;
  return {tau.c[3], tau.c[0] - tau.c[1], update.plastic_shear_rate};
}

template <class Real>
class OldroydBOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(OldroydBOf, Reals);

// tau_12 = (G lambda + eta_s) rate for any dt; N1 = 2 G (lambda rate)^2 with an error of G lambda rate^2 dt, backward
// Euler's.
TYPED_TEST(OldroydBOf, SteadyShearOfTheUpperConvectedForm) {
  const OldroydB law = fluid(OldroydB::Form::upper_convected, solvent);
  for (const double weissenberg : {0.1, 0.5, 1.0, 2.0}) {
    const double rate = weissenberg / relaxation_time;
    for (const double part : {0.02, 0.01}) {
      const double dt = part * relaxation_time;
      const Shear flow = shear<TypeParam>(law, rate, 40.0 * relaxation_time, dt);
      EXPECT_NEAR(flow.shear_stress, (G * relaxation_time + solvent) * rate, 1e-11 * G) << weissenberg;
      const double normal = 2.0 * G * weissenberg * weissenberg;
      EXPECT_NEAR(flow.normal_stress, normal + G * relaxation_time * rate * rate * dt, 1e-10 * G) << weissenberg;
    }
  }
}

TYPED_TEST(OldroydBOf, StartUpConvergesWithOrderOne) {
  const OldroydB law = fluid(OldroydB::Form::upper_convected);
  const double rate = 1.5 / relaxation_time, time = 1.2;  // in relaxation times
  const double shear_stress = G * 1.5 * (1.0 - std::exp(-time));
  const double normal_stress = 2.0 * G * 1.5 * 1.5 * (1.0 - std::exp(-time) * (1.0 + time));
  double error[3][2];
  for (int level = 0; level < 3; ++level) {
    const Shear flow = shear<TypeParam>(law, rate, time * relaxation_time, time * relaxation_time / (100 << level));
    error[level][0] = std::fabs(flow.shear_stress - shear_stress);
    error[level][1] = std::fabs(flow.normal_stress - normal_stress);
  }
  for (int level = 1; level < 3; ++level)
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(error[level - 1][k] / error[level][k]), 1.0, 0.05) << level << k;
  EXPECT_LT(error[2][0], 2e-3 * shear_stress);
}

// The isochoric form saturates. Values: steady state of db/dt = L b + b L^T - (b - 1) / lambda + zeta b, with zeta such that
// det b stays 1, by fourth-order Runge-Kutta.
TYPED_TEST(OldroydBOf, SteadyShearOfTheIsochoricFormSaturates) {
  const OldroydB law = fluid(OldroydB::Form::isochoric);
  const double weissenberg[] = {0.1, 0.5, 1.0, 2.0}, expected[] = {0.0993431, 0.4381442, 0.7016069, 0.9731483};
  for (int i = 0; i < 4; ++i) {
    const double rate = weissenberg[i] / relaxation_time;
    const auto run = [&](double dt) { return shear<TypeParam>(law, rate, 12.0 * relaxation_time, dt).shear_stress / G; };
    const double coarse = run(1e-3 * relaxation_time), fine = run(5e-4 * relaxation_time);
    EXPECT_NEAR(2.0 * fine - coarse, expected[i], 1e-6) << weissenberg[i];
  }
}

TYPED_TEST(OldroydBOf, IsochoricFormKeepsTheDeterminant) {
  const OldroydB law = fluid(OldroydB::Form::isochoric);
  std::mt19937_64 random(72);
  auto state = state_at_rest(law);
  for (int step = 0; step < 2000; ++step) {
    advance<TypeParam>(law, state, random_tensor(random, 50.0), 1e-3);
    EXPECT_NEAR(determinant(state.left_cauchy_green), 1.0, 1e-14);
    if (std::fabs(std::log(state.volume_ratio)) > 1.0) state.volume_ratio = 1.0;
  }
}

// b - 1 decays by 1 / (1 + dt / lambda) a step; small elastic strain is that of a Maxwell fluid in both forms.
TYPED_TEST(OldroydBOf, StressRelaxes) {
  for (const auto form : {OldroydB::Form::upper_convected, OldroydB::Form::isochoric}) {
    const OldroydB law = fluid(form);
    auto state = state_at_rest(law);
    double previous = advance<TypeParam>(law, state, simple_shear(1e-3), 1.0).kirchhoff_stress.c[3];
    state = state_at_rest(law);
    deform(state, simple_shear(1e-3), 1.0);
    previous = law.kirchhoff_stress(state).c[3];
    for (int step = 0; step < 100; ++step) {
      const double now = advance<TypeParam>(law, state, Tensor<double>{}, 0.1 * relaxation_time).kirchhoff_stress.c[3];
      EXPECT_NEAR(now, previous / 1.1, 1e-6 * previous);
      previous = now;
    }
  }
}

// The rate reported tends to the shear rate; energy is supplied, stored and dissipated in balance as dt falls.
TYPED_TEST(OldroydBOf, RateAndDissipationInSteadyShear) {
  for (const auto form : {OldroydB::Form::upper_convected, OldroydB::Form::isochoric}) {
    const OldroydB law = fluid(form, solvent);
    const double rate = 0.05 / relaxation_time, dt = 1e-3 * relaxation_time;
    auto state = state_at_rest(law);
    Update<double> update{};
    for (int step = 0; step < 20000; ++step) update = advance<TypeParam>(law, state, simple_shear(rate), dt);
    EXPECT_NEAR(update.plastic_shear_rate, rate, 5e-3 * rate);
    EXPECT_NEAR(update.dissipation, update.kirchhoff_stress.c[3] * rate * dt, 2e-3 * update.dissipation);
  }
}

}  // namespace
}  // namespace bulkley::oldroyd_b_test
