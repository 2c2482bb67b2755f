// One step of the full tensor law. Reference table: 15 digits, exact restoration of det b.

#include "material/laws/herschel_bulkley.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <vector>

#include "support/random_vectors.hpp"
#include "support.hpp"

namespace bulkley::herschel_bulkley_test {
namespace {

using namespace material_test;

constexpr double infinity = std::numeric_limits<double>::infinity();

// The tables list 11 22 33 12 13 23.
SymTensor<double> from_table(const double (&t)[6]) { return {{t[0], t[1], t[2], t[3], t[5], t[4]}}; }

struct TensorCase {
  const char* id;
  double dt, kappa, mu, sigma_Y, eta, h;
  Tensor<double> L;
  double start[6];
  double rate, J;
  double b[6], tau[6];
};
void PrintTo(const TensorCase& c, std::ostream* out) { *out << c.id; }

// clang-format off
const TensorCase tensor_cases[] = {
    {"T1_simple_shear", 0.01, 109000, 290, 31.9, 27.2, 0.22, {{0, 50, 0, 0, 0, 0, 0, 0, 0}}, {1, 1, 1, 0, 0, 0},
     21.335489581849, 1.0,
     {1.07409654102828, 0.981121492655715, 0.981121492655715, 0.185950096745135, 0.0, 0.0},
     {17.9751760186964, -8.98758800934818, -8.98758800934818, 53.9255280560891, 0.0, 0.0}},
    {"T2_general", 0.01, 109000, 290, 31.9, 27.2, 0.22, {{10, -20, 5, 30, -4, 0, -7, 12, -9}}, {1, 1, 1, 0, 0, 0},
     6.7556434839587, 1.02072,
     {1.14353217668806, 0.993344667520684, 0.890975265257159, 0.0860351858244003, -0.0346011073424219, 0.0587283659757863},
     {2320.80981345783, 2277.25543579929, 2247.56830914287, 24.9502038890761, -10.0343211293023, 17.031226132978}},
    {"T3_stretch_bingham", 0.001, 10000, 1000, 30, 10, 1, {{40, 0, 0, 0, -20, 0, 0, 0, -20}}, {1, 1, 1, 0, 0, 0},
     6.2187937266274, 0.998816,
     {1.07191238960036, 0.965873730970027, 0.965873730970027, 0.0, 0.0, 0.0},
     {58.8594483668877, -47.1792102634438, -47.1792102634438, 0.0, 0.0, 0.0}},
    {"T4_thickening", 0.001, 100000, 10000, 0.1, 10, 2.8, {{0, 100, 0, 0, 0, 0, 0, 0, 0}}, {1, 1, 1, 0, 0, 0},
     5.69181168899926, 1.0,
     {1.00894737914731, 0.99975366333258, 0.99975366333258, 0.0919371581473149, 0.0, 0.0},
     {61.2914387648766, -30.6457193824383, -30.6457193824383, 919.371581473149, 0.0, 0.0}},
    {"T5_elastic", 0.01, 109000, 290, 31.9, 27.2, 0.22, {{0, 1, 0, 0, 0, 0, 0, 0, 0}}, {1, 1, 1, 0, 0, 0}, 0.0, 1.0,
     {1.0001, 1.0, 1.0, 0.01, 0.0, 0.0},
     {0.0193333333333333, -0.00966666666666667, -0.00966666666666667, 2.9, 0.0, 0.0}},
    {"T6_rotation_of_T1", 0.001, 109000, 290, 31.9, 27.2, 0.22, {{0, -3, 0, 3, 0, 0, 0, 0, 0}},
     {1.07409654102828, 0.981121492655715, 0.981121492655715, 0.185950096745135, 0.0, 0.0},
     11.519480573216, 1.000009,
     {1.06584779869081, 0.982836009518967, 0.981806520075159, 0.170361324539889, 0.0, 0.0},
     {17.1294676339586, -6.94395122587724, -7.2425031645814, 49.4047841165678, 0.0, 0.0}},
    {"T7_compression", 0.001, 109000, 290, 31.9, 27.2, 0.22, {{-5, 0, 0, 0, -5, 0, 0, 0, -5}}, {1, 1, 1, 0, 0, 0}, 0.0,
     0.985074875, {1, 1, 1, 0, 0, 0},
     {-1614.69824008352, -1614.69824008352, -1614.69824008352, 0.0, 0.0, 0.0}},
};
// clang-format on

class TensorTable : public testing::TestWithParam<TensorCase> {};

TEST_P(TensorTable, AgreesWithTheReference) {
  const TensorCase& c = GetParam();
  const HerschelBulkley law{{1000.0, c.kappa, c.mu, c.sigma_Y, c.eta, c.h}};
  State<double> state{from_table(c.start), 1.0};
  const auto result = law.update(state, c.L, c.dt);
  const SymTensor<double> b = from_table(c.b), tau = from_table(c.tau);
  EXPECT_LT(largest_difference(state.left_cauchy_green, b), 1e-11 * largest_component(b));
  EXPECT_LT(largest_difference(result.kirchhoff_stress, tau), 1e-11 * largest_component(tau));
  EXPECT_NEAR(state.volume_ratio, c.J, 1e-14);
  EXPECT_NEAR(result.plastic_shear_rate, std::sqrt(2.0) * c.rate, 1e-9 * c.rate);
  EXPECT_NEAR(determinant(state.left_cauchy_green), 1.0, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(TableC, TensorTable, testing::ValuesIn(tensor_cases),
                         [](const auto& test) { return test.param.id; });

// --- invariants over random steps --------------------------------------------------------------------------------------

struct LawCase {
  const char* id;
  HerschelBulkley law;
};
void PrintTo(const LawCase& c, std::ostream* out) { *out << c.id; }

const LawCase law_cases[] = {
    {"foam", foam()},
    {"stiff_foam", {{200.0, 109000.0, 29000.0, 31.9, 27.2, 0.22}}},
    {"bingham", {{1000.0, 1e5, 1e4, 30.0, 10.0, 1.0}}},
    {"thickening", {{1000.0, 1e5, 1e4, 0.1, 10.0, 2.8}}},
    {"extreme_thinning", {{1000.0, 1e5, 1e4, 5.0, 3.0, 0.1}}},
    {"extreme_thickening", {{1000.0, 1e5, 1e4, 5.0, 3.0, 3.0}}},
    {"no_yield_stress", {{1000.0, 1e5, 1e4, 0.0, 10.0, 0.5}}},
    {"plastic", {{1000.0, 1e5, 1e4, 30.0, 0.0, 0.5}}},
    {"elastic", {{1000.0, 1e5, 1e4, 30.0, infinity, 0.5}}},
    {"no_shear_modulus", {{1000.0, 1e5, 0.0, 30.0, 10.0, 0.5}}},
};

class EveryLaw : public testing::TestWithParam<LawCase> {
 protected:
  const HerschelBulkley& law() const { return GetParam().law; }
};

TEST_P(EveryLaw, RandomStepsKeepTheInvariants) {
  std::mt19937_64 random(11);
  for (int path = 0; path < 40; ++path) {
    State<double> state = at_rest();
    for (int step = 0; step < 50; ++step) {
      const Tensor<double> L = random_tensor(random, 30.0);
      State<double> trial = state;
      law().elastic().update(trial, L, 1e-3);
      const double trial_mean = trace(trial.left_cauchy_green) / 3.0;
      const auto result = law().update(state, L, 1e-3);
      const double mean = trace(state.left_cauchy_green) / 3.0;
      EXPECT_NEAR(determinant(state.left_cauchy_green), 1.0, 1e-12);
      EXPECT_GE(mean, 1.0 - 1e-15);
      EXPECT_LE(mean, trial_mean * (1.0 + 1e-15));
      EXPECT_EQ(state.volume_ratio, trial.volume_ratio);  // flow keeps the volume
      EXPECT_GE(result.dissipation, 0.0);
      EXPECT_GE(result.plastic_shear_rate, 0.0);
      // The stress falls during the step: at its end it dissipates less than the energy that the flow takes away.
      const double scale = law().parameters.shear_modulus * trial_mean + 1e-3 * law().parameters.bulk_modulus;
      const double lost = law().energy_density(trial) - law().energy_density(state);
      EXPECT_LE(result.dissipation, lost + 1e-13 * scale);
      EXPECT_EQ(result.dissipation > 0.0, result.plastic_shear_rate > 0.0);
      // The stress returned is the stress of the state, to rounding.
      EXPECT_LE(largest_difference(result.kirchhoff_stress, law().kirchhoff_stress(state)),
                1e-15 * (scale + largest_component(result.kirchhoff_stress)));
    }
  }
}

// A superposed rotation f -> Q f, and a rotated start with f -> Q f Q^T, both rotate the outcome.
TEST_P(EveryLaw, IsObjective) {
  std::mt19937_64 random(12);
  constexpr double dt = 1e-3;
  for (int i = 0; i < 200; ++i) {
    const State<double> start = random_state(random, 0.05);
    const Tensor<double> L = random_tensor(random, 40.0);
    State<double> plain = start;
    const auto result = law().update(plain, L, dt);

    const Eigen::Matrix3d Q = random_rotation(random);
    Tensor<double> rotation;
    Eigen::Matrix3d f = Eigen::Matrix3d::Identity();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        rotation(r, c) = Q(r, c);
        f(r, c) += dt * L(r, c);
      }
    }
    const SymTensor<double> expected_b = push_forward(rotation, plain.left_cauchy_green);
    const SymTensor<double> expected_tau = push_forward(rotation, result.kirchhoff_stress);
    const auto expect_rotated = [&](State<double> state, const Eigen::Matrix3d& other_f) {
      Tensor<double> other_L;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) other_L(r, c) = (other_f(r, c) - (r == c ? 1.0 : 0.0)) / dt;
      const auto other = law().update(state, other_L, dt);
      EXPECT_LT(largest_difference(state.left_cauchy_green, expected_b), 1e-13);
      const double modulus = law().parameters.bulk_modulus + law().parameters.shear_modulus;
      EXPECT_LT(largest_difference(other.kirchhoff_stress, expected_tau), 1e-13 * modulus);
    };
    expect_rotated(start, Q * f);
    expect_rotated({push_forward(rotation, start.left_cauchy_green), start.volume_ratio}, Q * f * Q.transpose());
  }
}

// Elastic, just yielding and far beyond yield side by side, in steps from tiny to huge: a lane gives the bits of the scalar
// path.
TEST_P(EveryLaw, EachLaneIsTheScalarResult) {
  std::mt19937_64 random(13);
  const double increments[] = {0.0, 1e-9, 5e-4, 2e-3, 1e-2, 5e-2, 0.2, 2e-2};  // dt |L|
  for (const double dt : {1e-12, 1e-3, 10.0}) {
    for (int i = 0; i < 200; ++i) {
      State<double> one[n_lanes];
      Tensor<double> L[n_lanes];
      State<Pack> state;
      Tensor<Pack> gradient;
      for (int lane = 0; lane < n_lanes; ++lane) {
        one[lane] = random_state(random, 1e-3 * lane);
        L[lane] = random_tensor(random, increments[(lane + i) % 8] / dt);
        for (int c = 0; c < 6; ++c) state.left_cauchy_green.c[c][lane] = one[lane].left_cauchy_green.c[c];
        state.volume_ratio[lane] = one[lane].volume_ratio;
        for (int c = 0; c < 9; ++c) gradient.c[c][lane] = L[lane].c[c];
      }
      const auto packs = law().update(state, gradient, dt);
      for (int lane = 0; lane < n_lanes; ++lane) {
        const auto scalar = law().update(one[lane], L[lane], dt);
        const auto expect_same = [&](const Pack& pack, double expected) {
          EXPECT_EQ(to_bits(double{pack[lane]}), to_bits(expected)) << "lane " << lane << ", dt " << dt;
        };
        for (int c = 0; c < 6; ++c) {
          expect_same(state.left_cauchy_green.c[c], one[lane].left_cauchy_green.c[c]);
          expect_same(packs.kirchhoff_stress.c[c], scalar.kirchhoff_stress.c[c]);
        }
        expect_same(state.volume_ratio, one[lane].volume_ratio);
        expect_same(packs.plastic_shear_rate, scalar.plastic_shear_rate);
        expect_same(packs.dissipation, scalar.dissipation);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(HerschelBulkley, EveryLaw, testing::ValuesIn(law_cases),
                         [](const auto& test) { return test.param.id; });

// --- the flow curve -----------------------------------------------------------------------------------------------------

// A rheometer measures Cauchy stress: its curve holds however much an artificially low bulk modulus lets the fluid be compressed.
TEST(HerschelBulkleyFlow, TheCurveIsOneOfTheCauchyStressAtAnyVolumeRatio) {
  constexpr double rate = 3.0;
  for (const double J : {0.7, 0.95, 1.0, 1.4}) {
    for (const double h : {0.4, 1.0, 2.0}) {
      const HerschelBulkley fluid{{1000.0, 1e7, 1e6, 20.0, 10.0, h}};
      const ShearRheometerConstants curve = shear_rheometer_constants(fluid.parameters);
      State<double> state = at_rest();
      state.volume_ratio = J;
      double stress = 0.0, dissipation = 0.0;
      for (int step = 0; step < 20000; ++step) {
        const auto result = fluid.update(state, simple_shear(rate), 1e-4);
        stress = result.kirchhoff_stress.c[3] / state.volume_ratio;
        dissipation = result.dissipation / 1e-4;
      }
      const double expected = curve.yield_stress + curve.consistency * std::pow(rate, h);
      EXPECT_NEAR(stress, expected, 1e-5 * expected) << J << ' ' << h;
      EXPECT_NEAR(dissipation, J * expected * rate, 1e-4 * J * expected * rate) << J << ' ' << h;  // per reference volume
    }
  }
}

// --- degenerate parameters ----------------------------------------------------------------------------------------------

TEST(HerschelBulkleyLimits, BelowYieldItIsTheElasticSolidBitForBit) {
  std::mt19937_64 random(14);
  HerschelBulkley stiff = foam(), rigid = foam();
  stiff.parameters.sigma_Y = 1e12;
  rigid.parameters.eta = infinity;
  for (int i = 0; i < 100; ++i) {
    const Tensor<double> L = random_tensor(random, 50.0);
    State<double> a = random_state(random, 0.1), b = a, c = a;
    const auto elastic = foam().elastic().update(a, L, 1e-3);
    for (const auto& other : {stiff.update(b, L, 1e-3), rigid.update(c, L, 1e-3)}) {
      EXPECT_EQ(largest_difference(elastic.kirchhoff_stress, other.kirchhoff_stress), 0.0);
      EXPECT_EQ(other.plastic_shear_rate, 0.0);
      EXPECT_EQ(other.dissipation, 0.0);
    }
    EXPECT_EQ(largest_difference(a.left_cauchy_green, b.left_cauchy_green), 0.0);
    EXPECT_EQ(largest_difference(a.left_cauchy_green, c.left_cauchy_green), 0.0);
  }
}

// The table that a law carries is a matter of speed only: after a change of eta or h it must not be used.
TEST(HerschelBulkleyLimits, AParameterThatChangesLaterCounts) {
  std::mt19937_64 random(15);
  HerschelBulkley other_eta = foam(), other_h = foam();
  other_eta.parameters.eta = 3.0;
  other_h.parameters.h = 0.8;
  for (const HerschelBulkley& changed : {other_eta, other_h}) {
    const HerschelBulkley made_so{changed.parameters};
    for (int i = 0; i < 100; ++i) {
      const Tensor<double> L = random_tensor(random, 50.0);
      State<double> a = random_state(random, 0.1), b = a;
      const auto late = changed.update(a, L, 1e-3), early = made_so.update(b, L, 1e-3);
      EXPECT_LT(largest_difference(a.left_cauchy_green, b.left_cauchy_green), 1e-14);
      EXPECT_NEAR(late.plastic_shear_rate, early.plastic_shear_rate, 1e-11 * early.plastic_shear_rate);
    }
  }
}

TEST(HerschelBulkleyLimits, WithoutConsistencyTheStressLiesOnTheYieldSurface) {
  HerschelBulkley plastic = foam();
  plastic.parameters.eta = 0.0;
  State<double> state = at_rest();
  for (int step = 0; step < 100; ++step) {
    const auto result = plastic.update(state, simple_shear(50.0), 1e-2);
    EXPECT_NEAR(norm(deviator(result.kirchhoff_stress)), std::sqrt(2.0 / 3.0) * 31.9, 1e-11);
  }
}

// Newton's fluid with relaxation (Maxwell): the stress decays as in backward Euler of ds/dt = -2 mu s / eta.
TEST(HerschelBulkleyLimits, WithoutYieldStressAndWithIndexOneItIsAMaxwellFluid) {
  const HerschelBulkley maxwell{{1000.0, 1e5, 1e4, 0.0, 10.0, 1.0}};
  State<double> state = at_rest();
  state.left_cauchy_green = {{1.0, 1.0, 1.0 / (1.0 - 1e-8), 1e-4, 0, 0}};
  double s = norm(deviator(maxwell.kirchhoff_stress(state)));
  for (int step = 0; step < 50; ++step) {
    const auto result = maxwell.update(state, Tensor<double>{}, 1e-5);
    s /= 1.0 + 2.0 * 1e4 * 1e-5 / 10.0;
    EXPECT_NEAR(norm(deviator(result.kirchhoff_stress)), s, 1e-7 * s) << step;
  }
}

// Viscosities of its limits in steady shear: eta / 2 for h = 1, and K = eta 2^(-(1+h)/2).
TEST(HerschelBulkleyLimits, WithoutYieldStressItIsAPowerLawFluid) {
  for (const double h : {0.5, 1.0, 2.0}) {
    const HerschelBulkley fluid{{1000.0, 1e7, 1e6, 0.0, 10.0, h}};
    State<double> state = at_rest();
    double stress = 0.0;
    for (int step = 0; step < 20000; ++step) stress = fluid.update(state, simple_shear(3.0), 1e-4).kirchhoff_stress.c[3];
    EXPECT_NEAR(stress, 10.0 * std::pow(2.0, -0.5 * (1.0 + h)) * std::pow(3.0, h), 1e-5 * stress) << h;
  }
}

TEST(HerschelBulkleyLimits, ABackgroundAddsItsNewtonianStressAndNothingElse) {
  std::mt19937_64 random(16);
  HerschelBulkley both = foam();
  both.parameters.background_viscosity = 0.8;
  EXPECT_EQ(both.viscosity(), 0.8);
  EXPECT_EQ(foam().viscosity(), 0.0);
  State<double> state = at_rest(), alone = at_rest();
  for (int step = 0; step < 200; ++step) {
    const Tensor<double> L = random_tensor(random, 30.0);
    const auto update = both.update(state, L, 1e-3), expected = foam().update(alone, L, 1e-3);
    EXPECT_EQ(largest_difference(state.left_cauchy_green, alone.left_cauchy_green), 0.0);
    EXPECT_EQ(update.plastic_shear_rate, expected.plastic_shear_rate);
    SymTensor<double> rate;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j)
        rate.c[symmetric_index(i, j)] = 0.5 * (L(i, j) + L(j, i)) - (i == j ? (L(0, 0) + L(1, 1) + L(2, 2)) / 3.0 : 0.0);
    for (int c = 0; c < 6; ++c)
      EXPECT_NEAR(update.kirchhoff_stress.c[c] - expected.kirchhoff_stress.c[c], 1.6 * state.volume_ratio * rate.c[c],
                  1e-15 * (largest_component(expected.kirchhoff_stress) + largest_component(rate)));
    EXPECT_NEAR(update.dissipation - expected.dissipation, 1.6 * state.volume_ratio * norm_squared(rate) * 1e-3, 1e-12);
  }
}

// The tables of one step through Pack arithmetic.
TEST_P(TensorTable, AgreesWithTheReferenceInEveryLane) {
  const TensorCase& c = GetParam();
  const HerschelBulkley law{{1000.0, c.kappa, c.mu, c.sigma_Y, c.eta, c.h}};
  State<double> state{from_table(c.start), 1.0};
  const auto result = advance<Pack>(law, state, c.L, c.dt);
  const SymTensor<double> b = from_table(c.b), tau = from_table(c.tau);
  EXPECT_LT(largest_difference(state.left_cauchy_green, b), 1e-11 * largest_component(b));
  EXPECT_LT(largest_difference(result.kirchhoff_stress, tau), 1e-11 * largest_component(tau));
  EXPECT_NEAR(result.plastic_shear_rate, std::sqrt(2.0) * c.rate, 1e-9 * c.rate);
}

}  // namespace
}  // namespace bulkley::herschel_bulkley_test
