// Reference values: 40-digit solutions of the same equations.

#include "material/return_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <vector>

namespace bulkley::return_map_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

FlowRule<double> rule(double sigma_Y, double eta, double h) { return {std::sqrt(2.0 / 3.0) * sigma_Y, eta, h}; }

bool same_bits(double a, double b) { return to_bits(a) == to_bits(b); }

// --- the scalar return ------------------------------------------------------------------------------------------------

struct ReturnCase {
  const char* id;
  double trial_norm, modulus, dt, sigma_Y, eta, h, norm, rate;
};
void PrintTo(const ReturnCase& c, std::ostream* out) { *out << c.id; }

const ReturnCase return_cases[] = {
    {"S1", 100, 300, 1e-3, 30, 10, 1, 95.72612626949991, 7.1231228841668},
    {"S2", 100, 300, 1e-3, 30, 10, 0.5, 80.90643235974989, 31.82261273375},
    {"S3", 100, 300, 1e-3, 30, 10, 2, 98.36921023396006, 2.7179829433999},
    {"S4", 60, 300, 1e-4, 31.9, 27.2, 0.22, 59.83908849662723, 2.6818583895462},
    {"S5", 60, 300, 1e-2, 31.9, 27.2, 0.22, 53.61805370976252, 1.0636577150396},
    {"S6", 200, 300, 1e-4, 31.9, 27.2, 0.22, 147.0179758487755, 883.03373585374},
    {"S7", 25, 300, 1e-3, 31.9, 27.2, 0.22, 25.0, 0.0},
    {"S8", 26.05, 300, 1e-3, 31.9, 27.2, 0.22, 26.05, 2.8633184932242e-18},
    {"S9", 1000, 10000, 1e-4, 0.1, 10, 2.8, 989.679663494462, 5.160168252769},
    {"S10", 10000, 10000, 1e-5, 0.1, 10, 2.8, 9997.642668103297, 11.786659483516},
    {"S11", 0.5, 10000, 1e-4, 0.1, 10, 2.8, 0.1547469279536532, 0.17262653602317},
    {"S12", 500, 10000, 1e-3, 20, 0, 1, 16.32993161855452, 24.183503419072},
    {"S13", 500, 10000, 1e-3, 0, 5, 1, 100.0, 20.0},
    {"S14", 500, 10000, 1e-3, 0, 5, 0.3, 13.02902533434546, 24.348548733283},
    {"S15", 500, 10000, 1e-3, 0, 5, 1.5, 237.6056422092523, 13.119717889537},
    {"S16", 500, 10000, 1e-9, 20, 5, 0.6, 499.9592368563117, 2038.1571844129},
    {"S17", 500, 10000, 1e3, 20, 5, 0.6, 16.3384249282146, 2.4183078753589e-5},
    {"S18", 2000, 1600, 5e-5, 120, 5, 0.27, 160.4008984580726, 11497.494384637},
    {"S19", 150, 1000, 7.5e-5, 12.886748449274438, 9.816273704077167, 0.7050882349137566, 143.9283282147757,
     40.477811901495},
    {"S20", 1e6, 1e8, 1e-6, 3000, 200, 0.45, 11638.70818205055, 4941.8064590897},
    {"S21", 1e-3, 1e2, 1e-3, 1e-4, 1e-2, 0.9, 0.0001546626361094302, 0.0042266868194528},
    {"S22", 100, 300, 1e-3, 30, 10, 0.3333333333333333, 63.73823234491397, 60.436279425143},
};

class FlowReturnTable : public testing::TestWithParam<ReturnCase> {};

TEST_P(FlowReturnTable, AgreesWithTheReference) {
  const ReturnCase& c = GetParam();
  const auto table = make_overstress_table(c.eta, c.h);
  FlowRule<double> flow = rule(c.sigma_Y, c.eta, c.h);
  for (const OverstressTable* first_guess : {static_cast<const OverstressTable*>(nullptr), table.get()}) {
    flow.table = first_guess;
    for (const double mean : {1.0, 1.07, 4.0}) {
      const auto result = flow_return(c.trial_norm, c.modulus / mean, mean, c.dt, flow);
      EXPECT_EQ(result.yields, c.rate > 0.0);
      EXPECT_NEAR(result.norm, c.norm, 1e-12 * c.norm);
      EXPECT_NEAR(result.ratio * c.trial_norm, c.norm, 1e-12 * c.norm);
      EXPECT_NEAR(result.rate, c.rate, 1e-9 * c.rate);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(TableA, FlowReturnTable, testing::ValuesIn(return_cases),
                         [](const auto& test) { return test.param.id; });

TEST(FlowReturn, NewtonFluidWithClosedForms) {
  for (const double dt : {1e-9, 1e-5, 1e-2, 10.0}) {
    const double a = 2.0 * 300.0 * dt / 10.0;
    const double radius = std::sqrt(2.0 / 3.0) * 30.0;
    const double expected = (100.0 + a * radius) / (1.0 + a);  // h = 1
    EXPECT_NEAR(flow_return(100.0, 300.0, 1.0, dt, rule(30.0, 10.0, 1.0)).norm, expected, 1e-14 * expected) << dt;
  }
}

TEST(FlowReturn, WithoutConsistencyTheStressFallsToTheYieldRadiusWhateverTheStep) {
  for (const double dt : {1e-12, 1e-3, 1e6}) {
    const auto result = flow_return(500.0, 1e4, 1.0, dt, rule(20.0, 0.0, 0.4));
    EXPECT_EQ(result.norm, rule(20.0, 0.0, 0.4).radius);
    EXPECT_NEAR(result.rate * dt, (500.0 - result.norm) / 2e4, 1e-15);
  }
}

TEST(FlowReturn, WithInfiniteConsistencyNothingFlows) {
  const auto result = flow_return(500.0, 1e4, 1.0, 1e-3, rule(20.0, infinity, 0.4));
  EXPECT_FALSE(result.yields);
  EXPECT_EQ(result.norm, 500.0);
  EXPECT_EQ(result.ratio, 1.0);
  EXPECT_EQ(result.rate, 0.0);
}

TEST(FlowReturn, StressExactlyAtTheYieldRadiusDoesNotFlow) {
  const FlowRule<double> at_yield = rule(30.0, 10.0, 0.5);
  EXPECT_FALSE(flow_return(at_yield.radius, 300.0, 1.0, 1e-3, at_yield).yields);
  const double above = std::nextafter(at_yield.radius, infinity);
  const auto result = flow_return(above, 300.0, 1.0, 1e-3, at_yield);
  EXPECT_TRUE(result.yields);
  EXPECT_GE(result.norm, at_yield.radius);
  EXPECT_LE(result.norm, above);
}

// Just above yield the flow rate is tiny, but must keep its relative accuracy: gamma = (overstress / eta)^(1/h) there.
TEST(FlowReturn, TinyRatesKeepTheirRelativeAccuracy) {
  for (const double h : {0.1, 0.22, 0.5, 1.0}) {
    for (const double overstress : {1e-2, 1e-4, 1e-6}) {
      const auto result = flow_return(overstress, 300.0, 1.0, 1e-9, rule(0.0, 10.0, h));
      const double expected = std::pow(result.norm / 10.0, 1.0 / h);
      EXPECT_GT(expected, 0.0);
      EXPECT_NEAR(result.rate, expected, 1e-11 * expected) << h << ' ' << overstress;
    }
  }
}

TEST(FlowReturn, NaNStaysNaN) {
  const auto result = flow_return(std::nan(""), 300.0, 1.0, 1e-3, rule(30.0, 10.0, 0.5));
  EXPECT_TRUE(std::isnan(result.norm));
}

// --- the dimensionless root -----------------------------------------------------------------------------------------------

struct RootRow {
  double h;
  double xi[5];  // A = 1e-6, 0.1, 1, 10, 1e6
};
void PrintTo(const RootRow& row, std::ostream* out) { *out << "h = " << row.h; }

const RootRow root_rows[] = {
    {0.2, {0.999999000005, 0.9303137377806066, 0.7548776662466928, 0.5401589210213829, 0.06228934585862883}},
    {0.22, {0.9999990000045454, 0.9285916530288844, 0.7421594985653294, 0.5140930036159536, 0.04735489207357361}},
    {0.25, {0.999999000004, 0.9263593057311732, 0.7244919590005156, 0.4779908014025168, 0.03137178849997259}},
    {1.0 / 3.0, {0.999999000003, 0.9216989942046786, 0.6823278038280193, 0.3930027389711052, 0.009966666790534978}},
    {0.5, {0.999999000002, 0.916079783099616, 0.6180339887498948, 0.2701562118716424, 0.0009995001249999922}},
    {0.75, {0.9999990000013333, 0.9116083827250232, 0.5497004779019703, 0.1565156508443918, 3.162202661650672e-5}},
    {1, {0.999999000001, 0.9090909090909091, 0.5, 0.09090909090909091, 9.99999000001e-7}},
    {1.5, {0.9999990000006667, 0.9063453912686299, 0.4301597090019467, 0.03020108468131428, 9.999999985e-10}},
    {2, {0.9999990000005, 0.9048750780274961, 0.3819660112501052, 0.0098048640721517, 9.99999999998e-13}},
    {2.8, {0.9999990000003571, 0.9035571861643201, 0.3282425814714824, 0.001577900880033761, 1.584893192461113e-17}},
    {3, {0.9999990000003333, 0.9033320576766703, 0.3176721961719807, 0.0009970119452715797, 1.0e-18}},
};

std::shared_ptr<const OverstressTable> table_of(double h) { return make_overstress_table(1.0, h); }

class SplitOverstressTable : public testing::TestWithParam<RootRow> {};

TEST_P(SplitOverstressTable, AgreesWithTheReference) {
  const double A[5] = {1e-6, 0.1, 1.0, 10.0, 1e6};
  const auto made = table_of(GetParam().h);
  for (int i = 0; i < 5; ++i) {
    const double expected = GetParam().xi[i];
    for (const OverstressTable* table : {static_cast<const OverstressTable*>(nullptr), made.get()}) {
      const auto split = split_overstress(std::log(A[i]), 1.0 / GetParam().h, true, table);
      EXPECT_NEAR(split.remaining, expected, 2e-12 * expected) << "A = " << A[i];
      EXPECT_NEAR(split.relaxed, 1.0 - expected, 1e-12 * (1.0 - expected) + 1e-15) << "A = " << A[i];
    }
  }
}

INSTANTIATE_TEST_SUITE_P(TableB, SplitOverstressTable, testing::ValuesIn(root_rows));

// Covers every flow index and any A, with and without first guesses; a root that the iteration had not reached would be NaN.
TEST(SplitOverstress, SatisfiesItsEquationEverywhere) {
  for (double h = 0.1; h <= 3.0; h += 0.05) {
    const double m = 1.0 / h;
    const auto table = table_of(h);
    for (const bool guessed : {false, true}) {
      for (double log_A = -800.0; log_A <= 800.0; log_A += std::fabs(log_A) < 40.0 ? 0.13 : 7.7) {
        const auto split = split_overstress(log_A, m, true, guessed ? table.get() : nullptr);
        EXPECT_NEAR(split.remaining + split.relaxed, 1.0, 4e-15) << h << ' ' << log_A;
        if (split.remaining < 1e-300) continue;
        // relaxed = A remaining^m to relative accuracy, compared in logarithms
        const double log_relaxed = log_A + m * std::log(split.remaining);
        if (log_relaxed < -700.0)
          EXPECT_LT(split.relaxed, 1e-303) << h << ' ' << log_A;
        else
          EXPECT_NEAR(std::log(split.relaxed), log_relaxed, 1e-13 * (1.0 + std::fabs(log_A))) << h << ' ' << log_A;
      }
    }
  }
}

TEST(SplitOverstress, LimitsOfSmallAndLargeA) {
  for (const double h : {0.1, 0.5, 1.0, 3.0}) {
    const auto small = split_overstress(std::log(1e-200), 1.0 / h, true, table_of(h).get());
    EXPECT_EQ(small.remaining, 1.0);
    EXPECT_NEAR(small.relaxed, 1e-200, 1e-213);
    const auto large = split_overstress(std::log(1e40), 1.0 / h, true, table_of(h).get());
    const double leading = std::pow(1e40, -h);
    EXPECT_NEAR(large.remaining, leading * (1.0 - h * leading), (2e-13 + 5.0 * leading * leading) * leading);
  }
}

// --- first guesses ------------------------------------------------------------------------------------------------------

TEST(OverstressTable, GuessesWithinItsStatedError) {
  for (const double h : {0.1, 0.15, 0.22, 0.5, 0.7, 1.0, 1.6, 2.8, 3.0}) {
    const auto table = table_of(h);
    for (double t = -15.0; t <= 15.0; t += 0.0137) {
      const double log_A = t < 0.0 ? t : t / h;
      const double exact = std::log(split_overstress(log_A, 1.0 / h, true, nullptr).remaining);
      EXPECT_NEAR(table->log_remaining(log_A), exact, 4e-6 * std::min(1.0, h)) << h << ' ' << log_A;
    }
  }
}

TEST(OverstressTable, BeyondItsRangeItKeepsToTheAsymptotes) {
  for (const double h : {0.1, 1.0, 3.0}) {
    const auto table = table_of(h);
    for (const double log_A : {-infinity, -1e300, -1000.0, -17.0}) EXPECT_NEAR(table->log_remaining(log_A), 0.0, 2e-7);
    for (const double t : {17.0, 1000.0, 1e300}) EXPECT_NEAR(table->log_remaining(t / h), -t, 1e-15 * t);
  }
}

TEST(OverstressTable, IsMissingWithoutParameters) {
  EXPECT_EQ(make_overstress_table(std::nan(""), 0.5), nullptr);
  EXPECT_EQ(make_overstress_table(1.0, std::nan("")), nullptr);
  EXPECT_NE(make_overstress_table(0.0, 0.5), nullptr);
}

// --- the spherical part -------------------------------------------------------------------------------------------------

double isochoric_mean(const SymTensor<double>& e, double upper) {
  return bulkley::isochoric_mean(0.5 * norm_squared(e), determinant(e), upper, true);
}

TEST(IsochoricMean, RestoresTheDeterminantForAnyScalingOfATrial) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (const double strain : {1e-8, 1e-3, 0.1, 1.0}) {
    for (int trial = 0; trial < 200; ++trial) {
      Tensor<double> f;
      for (double& c : f.c) c = strain * normal(random);
      for (int a = 0; a < 3; ++a) f(a, a) += 1.0;
      if (determinant(f) < 0.3) continue;
      SymTensor<double> b = push_forward(f, SymTensor<double>{{1, 1, 1, 0, 0, 0}});
      const double scale = std::cbrt(1.0 / determinant(b));
      for (double& c : b.c) c *= scale;
      const double upper = trace(b) / 3.0;
      for (const double kept : {0.0, 0.3, 0.9, 0.999999}) {
        SymTensor<double> e = deviator(b);
        for (double& c : e.c) c *= kept;
        const double x = isochoric_mean(e, upper);
        EXPECT_LE(x, upper);
        EXPECT_GE(x, 1.0 - 1e-15);
        SymTensor<double> restored = e;
        for (int a = 0; a < 3; ++a) restored.c[a] += x;
        EXPECT_NEAR(determinant(restored), 1.0, 1e-14 * (1.0 + std::pow(upper, 3)));
      }
    }
  }
}

// Rounding in the determinant then exceeds the tolerance of the search; it must still end.
TEST(IsochoricMean, EndsAtExtremeStretch) {
  for (double stretch = 10.0; stretch < 1e5; stretch *= 1.3) {
    const double mean = (stretch * stretch + 2.0 / stretch) / 3.0;
    for (double kept = 0.05; kept < 1.0; kept += 0.07) {
      const double side = kept * (1.0 / stretch - mean);
      const double x = isochoric_mean(SymTensor<double>{{-2.0 * side, side, side, 0, 0, 0}}, mean);
      EXPECT_NEAR(x, -side, 1e-6 * mean + 1.0 / std::sqrt(-3.0 * side)) << stretch << ' ' << kept;
    }
  }
}

// --- lanes ----------------------------------------------------------------------------------------------------------------

// Elastic, just yielding, far beyond yield, without consistency...: each lane must be what the scalar path gives, bit for
// bit, whatever the other lanes hold.
TEST(ReturnMap, EachLaneIsTheScalarResultWhateverItsNeighbours) {
  const double radius = rule(31.9, 0.0, 1.0).radius;
  const std::vector<double> trial_norms{0.0,    1e-300, 25.0,  radius,      std::nextafter(radius, infinity), 26.05, 60.0,
                                        2000.0, 1e9,    1e200, std::nan("")};
  for (const double h : {0.1, 0.22, 1.0, 2.8, 3.0}) {
    for (const double sigma_Y : {0.0, 31.9}) {
      for (const double eta : {0.0, 1e-300, 27.2, 1e300, infinity}) {
        const auto table = make_overstress_table(eta, h);
        for (const double dt : {1e-4, 1e-200, 1e3}) {
          for (std::size_t first = 0; first < trial_norms.size(); ++first) {
            FlowRule<double> flow = rule(sigma_Y, eta, h);
            flow.table = first % 2 == 0 ? table.get() : nullptr;
            Pack trial, mean;
            for (int lane = 0; lane < n_lanes; ++lane) {
              trial[lane] = trial_norms[(first + 3 * static_cast<std::size_t>(lane)) % trial_norms.size()];
              mean[lane] = 1.0 + 0.1 * lane;
            }
            const auto lanes = flow_return(trial, 290.0, mean, dt, flow);
            for (int lane = 0; lane < n_lanes; ++lane) {
              const auto scalar = flow_return(double{trial[lane]}, 290.0, double{mean[lane]}, dt, flow);
              const auto about = testing::Message()
                                 << trial[lane] << ' ' << h << ' ' << sigma_Y << ' ' << eta << ' ' << dt << ' ' << first;
              EXPECT_EQ(lanes.yields[lane] != 0, scalar.yields) << about;
              EXPECT_TRUE(same_bits(lanes.norm[lane], scalar.norm)) << about;
              EXPECT_TRUE(same_bits(lanes.ratio[lane], scalar.ratio)) << about;
              EXPECT_TRUE(same_bits(lanes.rate[lane], scalar.rate)) << about;
              EXPECT_TRUE(std::isnan(trial[lane]) || std::isfinite(scalar.norm)) << about;
            }
          }
        }
      }
    }
  }
}

TEST(ReturnMap, IsochoricMeanOfEachLaneIsTheScalarResult) {
  Pack J2, J3, upper;
  for (int lane = 0; lane < n_lanes; ++lane) {
    const double size = std::pow(10.0, lane - 6);
    const SymTensor<double> e{{size, -0.4 * size, -0.6 * size, 0.3 * size, -0.2 * size, 0.1 * size}};
    J2[lane] = 0.5 * norm_squared(e);
    J3[lane] = determinant(e);
    upper[lane] = 1.0 + 3.0 * size;
  }
  const Pack x = bulkley::isochoric_mean(J2, J3, upper, upper == upper);
  for (int lane = 0; lane < n_lanes; ++lane)
    EXPECT_TRUE(same_bits(x[lane], bulkley::isochoric_mean(double{J2[lane]}, double{J3[lane]}, double{upper[lane]}, true)))
        << lane;
}

}  // namespace
}  // namespace bulkley::return_map_test
