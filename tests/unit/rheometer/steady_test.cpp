// The flow curve that the kernel gives, against the steady solution of the continuous model with finite elastic strain.

#include "rheometer/steady.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>

#include "bulkley/base/error.hpp"
#include "rheometer/analytic.hpp"
#include "support.hpp"

namespace bulkley::rheometer::steady_test {
namespace {

using namespace rheometer_test;

struct SteadyCase {
  const char* id;
  HerschelBulkley law;
  double rate, small_strain, finite_strain, normal_difference;  // the last: 0 where not tabulated
};
void PrintTo(const SteadyCase& c, std::ostream* out) { *out << c.id; }

// Computed apart from this code, to 8 digits.
// clang-format off
const SteadyCase cases[] = {
    {"foam_0p1", foam(), 0.1, 29.155899, 28.962618, 5.80435},
    {"foam_1", foam(), 1.0, 36.238824, 35.870865, 8.91941},
    {"foam_10", foam(), 10.0, 47.993553, 47.154023, 15.4708},
    {"foam_50", foam(), 50.0, 60.559363, 58.912435, 24.2695},
    {"stiff_foam_0p1", stiff_foam(), 0.1, 29.155899, 29.155879, 0.0},
    {"stiff_foam_1", stiff_foam(), 1.0, 36.238824, 36.238786, 0.0},
    {"stiff_foam_10", stiff_foam(), 10.0, 47.993553, 47.993466, 0.0},
    {"stiff_foam_50", stiff_foam(), 50.0, 60.559363, 60.559187, 0.0},
    {"bingham_0p1", bingham(), 0.1, 17.820508, 17.82047, 0.0},
    {"bingham_1", bingham(), 1.0, 22.320508, 22.320434, 0.0},
    {"bingham_10", bingham(), 10.0, 67.320508, 67.318474, 0.0},
    {"bingham_50", bingham(), 50.0, 267.32051, 267.19328, 0.0},
    {"thickening_10", thickening(), 10.0, 1690.6661, 1659.1393, 0.0},
};
// clang-format on

class Steady : public testing::TestWithParam<SteadyCase> {};

TEST_P(Steady, KernelReachesTheTabulatedStress) {
  const SteadyCase& c = GetParam();
  const Measurement m = measure_steady(c.law, {.rates = {c.rate}});
  ASSERT_EQ(m.table.rows.size(), 1u);
  EXPECT_NEAR(m.table.column("shear_stress")[0], c.finite_strain, 1e-4 * c.finite_strain);
  EXPECT_EQ(m.table.column("steady")[0], 1.0);
  EXPECT_TRUE(m.remarks.empty());
  // N_1 has an error of first order in the step.
  if (c.normal_difference > 0.0) {
    EXPECT_NEAR(m.table.column("first_normal_stress_difference")[0], c.normal_difference, 3e-3 * c.normal_difference);
  }
  EXPECT_NEAR(m.table.column("second_normal_stress_difference")[0], 0.0, 1e-3 * c.finite_strain);
}

TEST_P(Steady, AnalyticCurveIsTheTable) {
  const SteadyCase& c = GetParam();
  const auto truth = steady_flow(c.law, Flow::simple_shear, c.rate);
  ASSERT_TRUE(truth);
  EXPECT_NEAR(truth->stress, c.finite_strain, 2e-7 * c.finite_strain);
  EXPECT_NEAR(truth->small_strain_stress, c.small_strain, 2e-7 * c.small_strain);
  if (c.normal_difference > 0.0) {
    EXPECT_NEAR(truth->first_normal_difference, c.normal_difference, 1e-5 * c.normal_difference);
  }
  const auto rate = steady_shear_rate(c.law, truth->stress);
  ASSERT_TRUE(rate);
  EXPECT_NEAR(*rate, c.rate, 1e-9 * c.rate);
}

INSTANTIATE_TEST_SUITE_P(Table, Steady, testing::ValuesIn(cases), [](const auto& test) { return test.param.id; });

TEST(SteadyShape, OfTheElasticStrain) {
  // gamma_dot / gamma and tau_12 / s at s / mu = 1, by way of a fluid with eta = 0 and its yield radius at s = mu.
  HerschelBulkley plastic{{1000.0, 1e5, 100.0, 100.0 * std::sqrt(1.5), 0.0, 1.0}};
  const auto flow = steady_flow(plastic, Flow::simple_shear, 1.0);
  ASSERT_TRUE(flow);
  EXPECT_NEAR(flow->stress, 56.93169044, 1e-6);
  EXPECT_NEAR(flow->first_normal_difference, 72.63847377, 1e-6);
}

// sigma_xx - sigma_yy = sqrt(3) (tau_y + K (sqrt(3) rate)^n), and in planar extension 2 (tau_y + K (2 rate)^n).
TEST(Extension, SmallStrainFollowsTheInvariants) {
  const HerschelBulkley law = stiff_foam();
  const ShearRheometerConstants c = shear_rheometer_constants(law.parameters);
  const double rate = 3.0;
  for (const auto& [flow, factor] : {std::pair{Flow::uniaxial_extension, std::sqrt(3.0)}, {Flow::planar_extension, 2.0}}) {
    const double expected = factor * (c.yield_stress + c.consistency * std::pow(factor * rate, c.flow_index));
    EXPECT_NEAR(steady_flow(law, flow, rate)->small_strain_stress, expected, 1e-10 * expected);
    const Measurement m = measure_steady(law, {.flow = flow, .rates = {rate}});
    EXPECT_NEAR(m.table.column("tensile_stress")[0], expected, 1e-2 * expected);
  }
}

TEST(Extension, KernelReachesTheFiniteStrainSolution) {
  for (const HerschelBulkley& law : {foam(), bingham(), thickening()})
    for (const Flow flow : {Flow::uniaxial_extension, Flow::planar_extension})
      for (const double rate : {0.5, 10.0}) {
        const Measurement m = measure_steady(law, {.flow = flow, .rates = {rate}, .strain_per_step = 5e-5});
        const double expected = steady_flow(law, flow, rate)->stress;
        EXPECT_NEAR(m.table.column("tensile_stress")[0], expected, 2e-4 * expected) << rate;
        EXPECT_EQ(m.table.column("steady")[0], 1.0);
      }
}

TEST(Steady, SolidIsSaidNotToBe) {
  const Measurement m = measure_steady(rubber(), {.rates = {1.0}, .largest_strain = 7.0});
  EXPECT_EQ(m.table.column("steady")[0], 0.0);
  ASSERT_EQ(m.remarks.size(), 1u);
  EXPECT_FALSE(m.table.has("analytic_stress"));
}

TEST(Pressure, IsReachedAndKept) {
  const Measurement m = measure_steady(foam(), {.rates = {1.0}, .pressure = 5000.0});
  EXPECT_NEAR(m.table.column("pressure")[0], 5000.0, 1e-3);
  const double J = loaded_specimen(foam(), 5000.0).volume_ratio();
  EXPECT_NEAR(0.5 * 109000.0 * (1.0 / J - J), 5000.0, 1e-5);
  // The flow curve does not know the pressure: only the elasticity of the Cauchy stress is 1 / J times as stiff.
  HerschelBulkley stiffer = foam();
  stiffer.parameters.shear_modulus /= J;
  const Measurement free = measure_steady(stiffer, {.rates = {1.0}});
  for (const char* column : {"shear_stress", "analytic_stress"})
    EXPECT_NEAR(m.table.column(column)[0], free.table.column(column)[0], 1e-6 * 35.87) << column;
  EXPECT_THROW(loaded_specimen(foam(), 1e9), UsageError);
}

}  // namespace
}  // namespace bulkley::rheometer::steady_test
