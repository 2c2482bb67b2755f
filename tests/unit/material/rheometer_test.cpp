// A single material point in a rheometer: start-up of simple shear until steady, against the steady solution of the
// continuous model with finite elastic strain, and the order of convergence in time.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <ostream>

#include "support.hpp"

namespace bulkley::rheometer_test {
namespace {

using namespace material_test;

struct Flow {
  double shear_stress;   // tau_12, Pa
  double normal_stress;  // N_1 = tau_11 - tau_22, Pa
  double dissipation;    // J/m^3 in the last step
  double b_22;
};

Flow shear(const HerschelBulkley& law, double rate, double dt, int n_steps) {
  State<double> state = at_rest();
  Update<double> result{};
  for (int step = 0; step < n_steps; ++step) result = law.update(state, simple_shear(rate), dt);
  const SymTensor<double>& tau = result.kirchhoff_stress;
  return {tau.c[3], tau.c[0] - tau.c[1], result.dissipation, state.left_cauchy_green.c[1]};
}

struct RheometerCase {
  const char* id;
  HerschelBulkley law;
  double rate;
  double shear_stress;
  double normal_stress;  // 0: not tabulated
};
void PrintTo(const RheometerCase& c, std::ostream* out) { *out << c.id; }

const HerschelBulkley stiff_foam{{200.0, 109000.0, 29000.0, 31.9, 27.2, 0.22}};
const HerschelBulkley bingham{{1000.0, 1e5, 1e4, 30.0, 10.0, 1.0}};
const HerschelBulkley thickening{{1000.0, 1e5, 1e4, 0.1, 10.0, 2.8}};

// clang-format off
const RheometerCase rheometer_cases[] = {
    {"foam_0p1", foam(), 0.1, 28.962618, 5.80435},
    {"foam_1", foam(), 1.0, 35.870865, 8.91941},
    {"foam_10", foam(), 10.0, 47.154023, 15.4708},
    {"foam_50", foam(), 50.0, 58.912435, 24.2695},
    {"stiff_foam_0p1", stiff_foam, 0.1, 29.155879, 0.0},
    {"stiff_foam_1", stiff_foam, 1.0, 36.238786, 0.0},
    {"stiff_foam_10", stiff_foam, 10.0, 47.993466, 0.0},
    {"stiff_foam_50", stiff_foam, 50.0, 60.559187, 0.0},
    {"bingham_0p1", bingham, 0.1, 17.82047, 0.0},
    {"bingham_1", bingham, 1.0, 22.320434, 0.0},
    {"bingham_10", bingham, 10.0, 67.318474, 0.0},
    {"bingham_50", bingham, 50.0, 267.19328, 0.0},
    {"thickening_10", thickening, 10.0, 1659.1393, 0.0},
};
// clang-format on

class Rheometer : public testing::TestWithParam<RheometerCase> {};

TEST_P(Rheometer, ReachesTheSteadyStress) {
  const RheometerCase& c = GetParam();
  constexpr double strain_per_step = 2e-4, strain = 6.0;
  const int n_steps = static_cast<int>(std::lround(strain / strain_per_step));
  const Flow flow = shear(c.law, c.rate, strain_per_step / c.rate, n_steps);
  EXPECT_NEAR(flow.shear_stress, c.shear_stress, 1e-4 * c.shear_stress);

  // N_1 and the dissipation have errors of first order in the step; the table holds the limit of N_1.
  const Flow finer = shear(c.law, c.rate, 0.5 * strain_per_step / c.rate, 2 * n_steps);
  if (c.normal_stress > 0.0) {
    EXPECT_NEAR(2.0 * finer.normal_stress - flow.normal_stress, c.normal_stress, 1e-4 * c.normal_stress);
  }

  // In steady flow all work is dissipated: stress times strain.
  const double supplied = strain_per_step * flow.shear_stress;
  EXPECT_NEAR(4.0 * finer.dissipation - flow.dissipation, supplied, 1e-4 * supplied);
}

INSTANTIATE_TEST_SUITE_P(Table, Rheometer, testing::ValuesIn(rheometer_cases),
                         [](const auto& test) { return test.param.id; });

// --- finite elastic strain ------------------------------------------------------------------------------------------------

// Steady simple shear of the continuous model at s / mu = elastic_strain, for any flow curve.
struct FiniteStrainRow {
  double elastic_strain, mean, rate_ratio, shear_stress, normal_stress;  // x, shear rate / gamma, tau_12 / s, N_1 / s
};
const FiniteStrainRow finite_strain_rows[] = {
    {0.01, 1.0000166661, 1.4142135632, 0.7070832129, 0.0099995000},
    {0.1, 1.0016611584, 1.4142213158, 0.7047691871, 0.0995046677},
    {0.2, 1.0065807074, 1.4143329095, 0.6979797940, 0.1961443897},
    {0.5, 1.0387808386, 1.4178974035, 0.6578775580, 0.4489892606},
    {1.0, 1.1345526618, 1.4475623880, 0.5693169044, 0.7263847377},
    {2.0, 1.4081332924, 1.5931333447, 0.4297990845, 0.9725318714},
    {5.0, 2.4520449338, 2.2557084096, 0.2491875403, 1.1461748162},
};

TEST(Rheometer, SteadyStateAtFiniteElasticStrain) {
  constexpr double mu = 1e3, eta = 10.0;
  const HerschelBulkley fluid{{1000.0, 1e5, mu, 0.0, eta, 1.0}};  // gamma = s / eta
  for (const FiniteStrainRow& row : finite_strain_rows) {
    const double s = row.elastic_strain * mu, rate = row.rate_ratio * s / eta;
    double values[2][4];
    for (int level = 0; level < 2; ++level) {
      const double dt = 1e-3 / (1 + level) * std::min(1.0, row.elastic_strain) / rate;
      State<double> state = at_rest();
      Update<double> update{};
      for (double strain = 0.0; strain < 12.0 * row.elastic_strain + 2.0 * row.elastic_strain * row.elastic_strain;
           strain += rate * dt)
        update = fluid.update(state, simple_shear(rate), dt);
      const SymTensor<double>& tau = update.kirchhoff_stress;
      const double of_level[] = {norm(deviator(tau)) / s, tau.c[3] / s, (tau.c[0] - tau.c[1]) / s,
                                 trace(state.left_cauchy_green) / 3.0};
      std::copy_n(of_level, 4, values[level]);
    }
    const double expected[] = {1.0, row.shear_stress, row.normal_stress, row.mean};
    for (int k = 0; k < 4; ++k)  // first order in dt, taken out
      EXPECT_NEAR(2.0 * values[1][k] - values[0][k], expected[k], 2e-5 * expected[k]) << row.elastic_strain << ' ' << k;
  }
}

// --- order of convergence -------------------------------------------------------------------------------------------------

struct StartUpCase {
  const char* id;
  HerschelBulkley law;
  double time, shear_stress, normal_stress;  // fourth-order Runge-Kutta of the continuous model, rate 10 1/s
  double error_at_80_steps;                  // of the stress tensor, relative
};
void PrintTo(const StartUpCase& c, std::ostream* out) { *out << c.id; }

const StartUpCase start_up_cases[] = {
    {"foam", foam(), 0.03, 47.4913135, 12.1201217, 6.8e-4},
    {"bingham", {{1000.0, 1e5, 1e3, 30.0, 10.0, 1.0}}, 0.02, 65.8923903, 7.82607144, 2.0e-3},
    {"thickening", thickening, 0.02, 785.482821, 95.5411386, 5.0e-3},
};

// ||dev tau|| in simple shear without a second normal stress difference.
double deviator_norm(double shear_stress, double normal_stress) {
  return std::sqrt(2.0 * shear_stress * shear_stress + 2.0 / 3.0 * normal_stress * normal_stress);
}

class StartUp : public testing::TestWithParam<StartUpCase> {};

TEST_P(StartUp, ConvergesWithOrderOne) {
  const StartUpCase& c = GetParam();
  std::array<double, 4> error;
  for (int level = 0; level < 4; ++level) {
    const int n_steps = 80 << level;
    const Flow flow = shear(c.law, 10.0, c.time / n_steps, n_steps);
    error[level] = deviator_norm(flow.shear_stress - c.shear_stress, flow.normal_stress - c.normal_stress) /
                   deviator_norm(c.shear_stress, c.normal_stress);
  }
  for (int level = 1; level < 4; ++level) EXPECT_NEAR(std::log2(error[level - 1] / error[level]), 1.0, 0.1) << level;
  EXPECT_NEAR(error[0], c.error_at_80_steps, 0.02 * c.error_at_80_steps);
}

INSTANTIATE_TEST_SUITE_P(Rate10, StartUp, testing::ValuesIn(start_up_cases), [](const auto& test) { return test.param.id; });

}  // namespace
}  // namespace bulkley::rheometer_test
