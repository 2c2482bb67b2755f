// A layer's flow against the flow rule itself, averaged over the layer by quadrature.

#include "material/layer_return.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace bulkley::layer_return_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double modulus = 290.0;

FlowRule<double> rule(double sigma_Y, double eta, double h) { return {std::sqrt(2.0 / 3.0) * sigma_Y, eta, h}; }

template <class Real>
FlowReturn<Real> in_layer(Real trial, double dt, const FlowRule<double>& flow, Real fall, Real mean = broadcast<Real>(1.0)) {
  return layer_return(flow_return(trial, modulus, mean, dt, flow), trial, modulus, mean, dt, flow, fall);
}

bool same_bits(double a, double b) { return to_bits(a) == to_bits(b); }

// The mean of the flow rule's rate for stresses from s - a to s + a: by Simpson's rule over what flows, in the variable whose power the
// rate's root at the yield stress is smooth in.
double mean_rate(double s, double a, const FlowRule<double>& flow) {
  const double low = std::max(s - a, flow.radius), high = s + a;
  if (high <= flow.radius) return 0.0;
  constexpr int n = 2000;
  const double from = std::sqrt(low - flow.radius), to = std::sqrt(high - flow.radius), step = (to - from) / n;
  double sum = 0.0;
  for (int k = 0; k <= n; ++k) {
    const double root = from + k * step;
    sum += (k == 0 || k == n ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) * std::pow(root * root / flow.eta, 1.0 / flow.h) * 2.0 * root;
  }
  return sum * step / 3.0 / (2.0 * a);
}

TEST(LayerReturn, RateIsTheMeanOfTheFlowRulesAcrossTheLayer) {
  for (const double h : {0.22, 0.5, 1.0, 2.0})
    for (const double fall : {0.01, 0.1, 0.5})
      for (const double excess : {-0.4, -0.05, 0.0, 0.05, 0.5, 3.0})
        for (const double dt : {1e-5, 1e-3, 0.1}) {
          const FlowRule<double> flow = rule(31.9, 27.2, h);
          const double trial = (1.0 + excess) * flow.radius, a = fall * flow.radius;
          const auto result = in_layer(trial, dt, flow, fall);
          const auto about = testing::Message() << h << ' ' << fall << ' ' << excess << ' ' << dt;
          EXPECT_EQ(result.yields, excess > -fall) << about;
          const double expected = mean_rate(result.norm, a, flow);
          EXPECT_NEAR(result.rate, expected, 1e-7 * expected) << about;
          EXPECT_NEAR(result.norm + 2.0 * modulus * dt * result.rate, trial, 2e-11 * trial) << about;
          EXPECT_NEAR(result.ratio * trial, result.norm, 1e-14 * trial) << about;
        }
}

// Where the upper end of the layer begins to flow.
TEST(LayerReturn, IsSmoothWhereAllOfTheLayerBeginsToFlow) {
  for (const double h : {0.1, 0.5, 1.0, 2.0})
    for (const double distance : {-1e-4, -1e-7, -1e-9, -1e-15, 0.0, 1e-15, 1e-9, 1e-7, 1e-6, 1e-4})
      for (const double dt : {1e-9, 1e-5, 1e-3}) {
        const FlowRule<double> flow = rule(31.9, 27.2, h);
        const double a = 0.25 * flow.radius, s = (flow.radius + a) * (1.0 + distance), rate = mean_rate(s, a, flow);
        const auto result = in_layer(s + 2.0 * modulus * dt * rate, dt, flow, 0.25);
        const auto about = testing::Message() << h << ' ' << distance << ' ' << dt;
        EXPECT_NEAR(result.norm, s, 1e-7 * s) << about;
        EXPECT_NEAR(result.rate, rate, 1e-6 * rate) << about;
      }
}

// Where the stress at the floor just exceeds the yield stress.
TEST(LayerReturn, TinyRatesKeepTheirRelativeAccuracy) {
  for (const double h : {0.1, 0.5, 1.0})
    for (const double excess : {1e-2, 1e-4}) {
      const FlowRule<double> flow = rule(31.9, 27.2, h);
      const double a = 0.25 * flow.radius, m = 1.0 / h;
      const auto result = in_layer(flow.radius - a + excess, 1e-9, flow, 0.25);
      const double expected = std::pow(result.norm - (flow.radius - a), m + 1.0) / (2.0 * a * (m + 1.0) * std::pow(flow.eta, m));
      EXPECT_GT(expected, 0.0);
      EXPECT_NEAR(result.rate, expected, 1e-9 * expected) << h << ' ' << excess;
    }
}

TEST(LayerReturn, WithoutConsistencyItStopsWhereTheStressAtTheFloorIsTheYieldStress) {
  const FlowRule<double> flow = rule(20.0, 0.0, 0.4);
  for (const double dt : {1e-12, 1e-3, 1e6}) {
    const auto result = in_layer(500.0, dt, flow, 0.3);
    EXPECT_DOUBLE_EQ(result.norm, 0.7 * flow.radius);
    EXPECT_NEAR(result.rate * dt, (500.0 - result.norm) / (2.0 * modulus), 1e-12);
  }
}

TEST(LayerReturn, WithoutAFallItIsTheFlowRules) {
  const FlowRule<double> flow = rule(20.0, 5.0, 0.6);
  for (const double trial : {10.0, 500.0}) {
    const auto plain = flow_return(trial, modulus, 1.0, 1e-3, flow), result = in_layer(trial, 1e-3, flow, 0.0);
    EXPECT_EQ(result.yields, plain.yields);
    EXPECT_TRUE(same_bits(result.norm, plain.norm) && same_bits(result.ratio, plain.ratio) && same_bits(result.rate, plain.rate));
  }
}

TEST(LayerReturn, NothingFlowsBelowYieldOrWithInfiniteConsistency) {
  for (const auto& [trial, flow] : {std::pair{11.0, rule(20.0, 5.0, 0.6)}, std::pair{500.0, rule(20.0, infinity, 0.6)}}) {
    const auto result = in_layer(trial, 1e-3, flow, 0.3);
    EXPECT_FALSE(result.yields);
    EXPECT_EQ(result.norm, trial);
    EXPECT_EQ(result.ratio, 1.0);
    EXPECT_EQ(result.rate, 0.0);
  }
}

// Where the fall is small next to the overstress, and where there is no yield stress: 1 + m (m - 1) / 6 (a / x)^2 + ...
TEST(LayerReturn, GoesOverIntoTheFlowRule) {
  for (const double h : {0.22, 0.5, 1.0, 2.0})
    for (const double sigma_Y : {20.0, 0.0})
      for (const double ratio : {1e2, 1e3, 1e5, 1e8, 1e12})
        for (const double dt : {1e-9, 1e-2}) {
          const FlowRule<double> flow = rule(sigma_Y, 50.0, h);
          const double trial = 2.0 * flow.radius + 20.0, m = 1.0 / h;
          const auto plain = flow_return(trial, modulus, 1.0, dt, flow), thin = in_layer(trial, dt, flow, 1.0 / ratio);
          const double a = flow.radius / ratio, x = plain.norm - flow.radius;
          EXPECT_NEAR(thin.rate, plain.rate, (1e-12 + 1.1 * std::abs(m * (m - 1.0)) / 6.0 * (a / x) * (a / x)) * plain.rate)
              << h << ' ' << sigma_Y << ' ' << ratio << ' ' << dt;
        }
}

// Without a fall, with one, beyond all bounds...: each lane must be what the scalar path gives, bit for bit, whatever the others hold.
TEST(LayerReturn, EachLaneIsTheScalarResultWhateverItsNeighbours) {
  const double radius = rule(31.9, 0.0, 1.0).radius;
  const std::vector<double> trial_norms{0.0, 1e-300, 20.0, radius, 26.05, 60.0, 2000.0, 1e9, 1e200, std::nan("")};
  const std::vector<double> falls{0.0, 0.1, 0.5, 1e-9, 0.3};
  for (const double h : {0.1, 0.22, 1.0, 2.8, 3.0})
    for (const double sigma_Y : {0.0, 31.9})
      for (const double eta : {0.0, 1e-300, 27.2, 1e300, infinity})
        for (const double dt : {1e-4, 1e-200, 1e3})
          for (std::size_t first = 0; first < trial_norms.size() * falls.size(); ++first) {
            const FlowRule<double> flow = rule(sigma_Y, eta, h);
            Pack trial, mean, fall;
            for (int lane = 0; lane < n_lanes; ++lane) {
              const std::size_t k = first + 3 * static_cast<std::size_t>(lane);
              trial[lane] = trial_norms[k % trial_norms.size()];
              fall[lane] = falls[(k / trial_norms.size()) % falls.size()];
              mean[lane] = 1.0 + 0.1 * lane;
            }
            const auto lanes = in_layer(trial, dt, flow, fall, mean);
            for (int lane = 0; lane < n_lanes; ++lane) {
              const auto scalar = in_layer(double{trial[lane]}, dt, flow, double{fall[lane]}, double{mean[lane]});
              const auto about = testing::Message()
                                 << trial[lane] << ' ' << fall[lane] << ' ' << h << ' ' << sigma_Y << ' ' << eta << ' ' << dt;
              ASSERT_EQ(lanes.yields[lane] != 0, scalar.yields) << about;
              ASSERT_TRUE(same_bits(lanes.norm[lane], scalar.norm)) << about;
              ASSERT_TRUE(same_bits(lanes.ratio[lane], scalar.ratio)) << about;
              ASSERT_TRUE(same_bits(lanes.rate[lane], scalar.rate)) << about;
              ASSERT_TRUE(std::isnan(trial[lane]) || std::isfinite(scalar.norm)) << about;
            }
          }
}

}  // namespace
}  // namespace bulkley::layer_return_test
