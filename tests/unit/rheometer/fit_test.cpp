// The fit of Herschel-Bulkley parameters, to curves that the test makes itself.

#include "rheometer/fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bulkley/base/error.hpp"
#include "rheometer/fit_report.hpp"

namespace bulkley::rheometer::fit_test {
namespace {

MeasuredCurve exact(const ShearRheometerConstants& c, int n_points = 25) {
  MeasuredCurve curve;
  for (const double rate : parse_number_list("0.01:1000:" + std::to_string(n_points), "rates")) {
    curve.shear_rate.push_back(rate);
    curve.stress.push_back(c.yield_stress + c.consistency * std::pow(rate, c.flow_index));
  }
  return curve;
}

// Relative scatter of the size `scatter`, and the column of errors that says so.
MeasuredCurve noisy(const ShearRheometerConstants& c, double scatter, unsigned seed) {
  MeasuredCurve curve = exact(c);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, scatter);
  for (double& stress : curve.stress) {
    curve.error.push_back(scatter * stress);
    stress *= 1.0 + normal(random);
  }
  return curve;
}

TEST(Fit, FindsExactDataAgain) {
  const ShearRheometerConstants cases[] = {
      {18.4, 17.8, 0.2237}, {3.2, 11.3, 0.7041}, {0.06, 3.8, 2.8052}, {120.0, 0.02, 1.3045}};
  for (const ShearRheometerConstants& c : cases)
    for (const Weights weights : {Weights::relative, Weights::uniform}) {
      const Fit fit = fit_herschel_bulkley(exact(c), {.weights = weights});
      // Beside 1e9 Pa at the fast end, a yield stress of 0.06 Pa is lost in uniform weights.
      const double tolerance = c.flow_index > 2.0 && weights == Weights::uniform ? 1e-3 : 1e-6;
      EXPECT_NEAR(fit.yield_stress.value, c.yield_stress, tolerance * c.yield_stress) << c.flow_index;
      EXPECT_NEAR(fit.consistency.value, c.consistency, 1e-6 * c.consistency);
      EXPECT_NEAR(fit.flow_index.value, c.flow_index, 1e-6 * c.flow_index);
      EXPECT_GT(fit.r_squared, 1.0 - 1e-9);
      EXPECT_LT(fit.relative_rms, tolerance);
    }
}

TEST(Fit, YueConventionIsTheConvertedOne) {
  const Fit fit = fit_herschel_bulkley(exact({18.417, 17.82135, 0.22}), {});
  EXPECT_NEAR(fit.sigma_Y.value, 31.899, 1e-3);
  EXPECT_NEAR(fit.eta.value, 27.2, 1e-4);
  EXPECT_NEAR(fit.h.value, 0.22, 1e-7);
}

TEST(Fit, NoisyDataWithinThreeStandardErrors) {
  const ShearRheometerConstants truth{5.0, 8.0, 0.5};
  const MeasuredCurve curve = noisy(truth, 0.02, 7);
  for (const Weights weights : {Weights::relative, Weights::error}) {
    const Fit fit = fit_herschel_bulkley(curve, {.weights = weights});
    EXPECT_NEAR(fit.yield_stress.value, truth.yield_stress, 3.0 * fit.yield_stress.standard_error);
    EXPECT_NEAR(fit.consistency.value, truth.consistency, 3.0 * fit.consistency.standard_error);
    EXPECT_NEAR(fit.flow_index.value, truth.flow_index, 3.0 * fit.flow_index.standard_error);
    EXPECT_LT(fit.yield_stress.standard_error, 0.1 * truth.yield_stress);
    EXPECT_GT(fit.flow_index.standard_error, 0.0);
    EXPECT_TRUE(fit.warnings.empty()) << fit.warnings.front();
  }
}

// The standard errors are the scatter of the estimates over many measurements.
TEST(Fit, StandardErrorsAreThoseOfRepeatedMeasurements) {
  const ShearRheometerConstants truth{5.0, 8.0, 0.5};
  constexpr int n_repeats = 400;
  double squares[4] = {}, claimed[4] = {};
  for (unsigned seed = 0; seed < n_repeats; ++seed) {
    const Fit fit = fit_herschel_bulkley(noisy(truth, 0.02, seed), {.weights = Weights::error});
    HerschelBulkley::Parameters yue;
    set_flow(yue, truth);
    const Parameter* estimates[] = {&fit.yield_stress, &fit.consistency, &fit.flow_index, &fit.eta};
    const double truths[] = {truth.yield_stress, truth.consistency, truth.flow_index, yue.eta};
    for (int k = 0; k < 4; ++k) {
      squares[k] += std::pow(estimates[k]->value - truths[k], 2) / n_repeats;
      claimed[k] += std::pow(estimates[k]->standard_error, 2) / n_repeats;
    }
  }
  // The scatter of a standard deviation from 400 samples is 3.5 %.
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(std::sqrt(squares[k] / claimed[k]), 1.0, 0.12) << k;
}

TEST(Fit, StaysInItsBounds) {
  // A negative yield stress would fit best.
  MeasuredCurve curve = exact({0.0, 10.0, 0.8});
  for (std::size_t k = 0; k < curve.stress.size(); ++k) curve.stress[k] *= curve.shear_rate[k] < 0.1 ? 0.7 : 1.0;
  const Fit fit = fit_herschel_bulkley(curve, {});
  EXPECT_EQ(fit.yield_stress.value, 0.0);
  EXPECT_EQ(fit.yield_stress.estimate, Estimate::at_lower_bound);
  EXPECT_TRUE(std::isnan(fit.yield_stress.standard_error));
  EXPECT_NE(fit_text(fit, {}).find("at its lower bound"), std::string::npos);

  const Fit steep = fit_herschel_bulkley(exact({1.0, 2.0, 3.5}), {});
  EXPECT_EQ(steep.flow_index.estimate, Estimate::at_upper_bound);
  EXPECT_EQ(steep.flow_index.value, 3.0);
  EXPECT_FALSE(steep.warnings.empty());

  MeasuredCurve falling = exact({10.0, 0.0, 1.0});
  for (std::size_t k = 0; k < falling.stress.size(); ++k) falling.stress[k] -= 0.05 * static_cast<double>(k);
  const Fit flat = fit_herschel_bulkley(falling, {});
  EXPECT_EQ(flat.consistency.value, 0.0);
  EXPECT_EQ(flat.eta.estimate, Estimate::at_lower_bound);
}

TEST(Fit, GivenValuesStay) {
  const ShearRheometerConstants truth{5.0, 8.0, 0.5};
  const Fit no_yield = fit_herschel_bulkley(noisy(truth, 0.02, 3), {.yield_stress = 0.0});
  EXPECT_EQ(no_yield.yield_stress.value, 0.0);
  EXPECT_EQ(no_yield.yield_stress.estimate, Estimate::fixed);
  const Fit no_consistency = fit_herschel_bulkley(noisy(truth, 0.02, 3), {.consistency = 8.0});
  const double per_index = 0.5 * std::log(2.0) * no_consistency.eta.value;
  EXPECT_NEAR(no_consistency.eta.standard_error, per_index * no_consistency.flow_index.standard_error, 1e-12);
  const Fit bingham = fit_herschel_bulkley(exact(truth), {.flow_index = 0.5});
  EXPECT_NEAR(bingham.yield_stress.value, 5.0, 1e-9);
  EXPECT_EQ(bingham.flow_index.estimate, Estimate::fixed);
  const Fit only_yield = fit_herschel_bulkley(exact(truth), {.consistency = 8.0, .flow_index = 0.5});
  EXPECT_NEAR(only_yield.yield_stress.value, 5.0, 1e-9);
  EXPECT_EQ(only_yield.eta.estimate, Estimate::fixed);
}

TEST(Fit, RangeLeavesPointsOut) {
  MeasuredCurve curve = exact({5.0, 8.0, 0.5});
  for (std::size_t k = 0; k < curve.stress.size(); ++k)
    if (curve.shear_rate[k] > 100.0) curve.stress[k] *= 3.0;
  const Fit fit = fit_herschel_bulkley(curve, {.rates = Range{0.0, 100.0}});
  EXPECT_EQ(fit.n_left_out, 5u);
  EXPECT_NEAR(fit.yield_stress.value, 5.0, 1e-5);
  EXPECT_FALSE(fit_herschel_bulkley(curve, {}).warnings.empty());  // poor over all points
  EXPECT_THROW(fit_herschel_bulkley(curve, {.rates = Range{500.0, 2000.0}}), UsageError);
  EXPECT_THROW(fit_herschel_bulkley(curve, {.weights = Weights::error}), UsageError);
}

// A Casson curve, whose best Herschel-Bulkley fit swings around it.
TEST(Fit, SaysThatResidualsAreNotScatter) {
  MeasuredCurve curve = exact({5.0, 8.0, 0.5});
  for (std::size_t k = 0; k < curve.stress.size(); ++k)
    curve.stress[k] = std::pow(std::sqrt(5.0) + std::sqrt(2.0 * curve.shear_rate[k]), 2);
  const Fit fit = fit_herschel_bulkley(curve, {});
  ASSERT_FALSE(fit.warnings.empty());
  EXPECT_NE(fit.warnings.back().find("not scatter"), std::string::npos) << fit.warnings.back();
}

std::string fault(const std::string& text) {
  try {
    parse_measured_curve(text, "curve.csv");
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

TEST(MeasuredCurve, IsReadByItsHeader) {
  const MeasuredCurve curve = parse_measured_curve(
      "\xEF\xBB\xBF# a comment\r\nstress, temperature ,shear_rate\r\n5.5,23,0.1\r\n\r\n 7e0 , 23 ,1\r\n", "f");
  EXPECT_EQ(curve.shear_rate, (std::vector<double>{0.1, 1.0}));
  EXPECT_EQ(curve.stress, (std::vector<double>{5.5, 7.0}));
  EXPECT_TRUE(curve.error.empty());
}

TEST(MeasuredCurve, FaultsNameFileAndLine) {
  EXPECT_EQ(fault(""), "curve.csv: is empty; it needs a header with the columns shear_rate and stress");
  EXPECT_EQ(fault("rate,stress\n1,2\n"), "curve.csv:1: the header has no column 'shear_rate'; it has 'rate', 'stress'");
  EXPECT_EQ(fault("shear_rate,stress\n1,2\n2,x\n"), "curve.csv:3: stress 'x' is not a finite number");
  EXPECT_EQ(fault("shear_rate,stress\n1,nan\n"), "curve.csv:2: stress 'nan' is not a finite number");
  EXPECT_EQ(fault("shear_rate,stress\n0,2\n"), "curve.csv:2: shear_rate 0 is not above 0");
  EXPECT_EQ(fault("shear_rate,stress\n1\n"), "curve.csv:2: 1 values under 2 columns");
  EXPECT_EQ(fault("shear_rate,stress,stress\n1,2,3\n"), "curve.csv:1: column 'stress' twice");
}

TEST(NumberList, CommasAndLogarithmicRanges) {
  EXPECT_EQ(parse_number_list("1,2.5,1e2", "--rates"), (std::vector<double>{1.0, 2.5, 100.0}));
  const std::vector<double> values = parse_number_list("0.01:100:5", "--rates");
  ASSERT_EQ(values.size(), 5u);
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(values[k], std::pow(10.0, k - 2), 1e-12 * std::pow(10.0, k - 2));
  for (const char* bad :
       {"", "1,", "a", "0", "-1", "1:2", "1:2:1", "2:1:5", "0:1:5", "1:2:2.5", "1:x:3", "1:2:3:4", "inf", "1e999"})
    EXPECT_THROW(parse_number_list(bad, "--rates"), UsageError) << bad;
  EXPECT_EQ(parse_number_list("0,1", "--rates", true), (std::vector<double>{0.0, 1.0}));
  for (const char* bad : {"", "1", "2:1", "-1:2", "1:2:3", "a:b"})
    EXPECT_THROW(parse_range(bad, "--range"), UsageError) << bad;
}

TEST(FitReport, SnippetHoldsTheFit) {
  const Fit fit = fit_herschel_bulkley(exact({5.0, 8.0, 0.5}), {});
  const std::string text = scene_snippet(fit, {.name = "sauce", .density = 1100.0, .speed = 2.0});
  for (const char* line :
       {"[materials.sauce]\n", "law = \"herschel_bulkley\"\n", "density = 1100 ", "bulk_modulus = 440000 ",
        "yield_stress = 5 ", "consistency = 8 ", "flow_index = 0.5\n", "shear_modulus = 5200 "})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
  EXPECT_EQ(material_name("a.b/chocolate sauce 23C.csv"), "chocolate_sauce_23C");
}

}  // namespace
}  // namespace bulkley::rheometer::fit_test
