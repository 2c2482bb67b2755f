// The weights have the moments of a B-spline (docs/theory.md, "Weights"), and the constants of the header follow from them.

#include "kernel/bspline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace bulkley::bspline_test {
namespace {

template <SplineOrder value>
struct Order {
  static constexpr SplineOrder order = value;
};

template <class T>
class Bspline : public testing::Test {
 public:
  static constexpr SplineOrder order = T::order;
  static constexpr int width = stencil_width(order);
  static constexpr double lowest = order == SplineOrder::quadratic ? 0.5 : 1.0;  // fx is in [lowest, lowest + 1)

  // Places in the cell: evenly spread, and as near to both edges as doubles go.
  static std::vector<double> places() {
    std::vector<double> result = {lowest, std::nextafter(lowest, 2.0), std::nextafter(lowest + 1.0, 0.0), lowest + 1.0,
                                  lowest + 0.5};
    for (int n = 0; n < 1000; ++n) result.push_back(lowest + (n + 0.37) / 1000.0);
    return result;
  }

  // The textbook spline of the distance u, in cells.
  static double N(double u) {
    const double a = std::abs(u);
    if (order == SplineOrder::quadratic) return a < 0.5 ? 0.75 - u * u : a < 1.5 ? 0.5 * (1.5 - a) * (1.5 - a) : 0.0;
    return a < 1.0 ? 0.5 * a * a * a - a * a + 2.0 / 3.0 : a < 2.0 ? std::pow(2.0 - a, 3) / 6.0 : 0.0;
  }
  static double dN(double u) {
    const double a = std::abs(u), sign = u < 0.0 ? -1.0 : 1.0;
    if (order == SplineOrder::quadratic) return a < 0.5 ? -2.0 * u : a < 1.5 ? u - 1.5 * sign : 0.0;
    return a < 1.0 ? u * (1.5 * a - 2.0) : a < 2.0 ? -0.5 * sign * (2.0 - a) * (2.0 - a) : 0.0;
  }
};
using Orders = testing::Types<Order<SplineOrder::quadratic>, Order<SplineOrder::cubic>>;
TYPED_TEST_SUITE(Bspline, Orders);

TYPED_TEST(Bspline, IntegralIsThatOfTheTextbook) {
  constexpr SplineOrder degree = TestFixture::order;
  const double end = 0.5 * TestFixture::width, step = 1e-3;
  EXPECT_EQ(spline_integral(degree, -end), 0.0);
  EXPECT_EQ(spline_integral(degree, 0.0), 0.5);
  EXPECT_EQ(spline_integral(degree, end), 1.0);
  EXPECT_EQ(spline_integral(degree, -1e3), 0.0);
  EXPECT_EQ(spline_integral(degree, 1e3), 1.0);
  double sum = 0.0;  // by Simpson's rule
  for (double x = -end; x < end - 0.5 * step; x += step) {
    sum += step / 6.0 * (TestFixture::N(x) + 4.0 * TestFixture::N(x + 0.5 * step) + TestFixture::N(x + step));
    EXPECT_NEAR(spline_integral(degree, x + step), sum, 1e-9) << x;
  }
}

TYPED_TEST(Bspline, EqualsTheTextbook) {
  for (const double fx : TestFixture::places()) {
    double w[TestFixture::width], d[TestFixture::width];
    spline_weights<TestFixture::order>(fx, w);
    spline_derivatives<TestFixture::order>(fx, d);
    for (int k = 0; k < TestFixture::width; ++k) {
      EXPECT_NEAR(w[k], TestFixture::N(fx - k), 1e-15) << fx;
      EXPECT_NEAR(d[k], TestFixture::dN(fx - k), 1e-15) << fx;
      EXPECT_GE(w[k], 0.0) << fx;
    }
  }
}

TYPED_TEST(Bspline, HasTheMomentsOfOneAxis) {
  for (const double fx : TestFixture::places()) {
    double w[TestFixture::width], d[TestFixture::width];
    spline_weights<TestFixture::order>(fx, w);
    spline_derivatives<TestFixture::order>(fx, d);
    double sum = 0.0, first = 0.0, second = 0.0, slope = 0.0, slope_first = 0.0;
    for (int k = 0; k < TestFixture::width; ++k) {
      sum += w[k];
      first += w[k] * (k - fx);
      second += w[k] * (k - fx) * (k - fx);
      slope += d[k];
      slope_first += d[k] * (k - fx);
    }
    EXPECT_NEAR(sum, 1.0, 1e-15) << fx;
    EXPECT_NEAR(first, 0.0, 1e-15) << fx;
    EXPECT_NEAR(second * inverse_second_moment(TestFixture::order), 1.0, 4e-15) << fx;
    EXPECT_NEAR(slope, 0.0, 1e-15) << fx;
    EXPECT_NEAR(slope_first, 1.0, 2e-15) << fx;
  }
}

TYPED_TEST(Bspline, PackLanesAreTheScalarBits) {
  const std::vector<double> places = TestFixture::places();
  for (std::size_t n = 0; n + n_lanes <= places.size(); n += n_lanes) {
    Pack w[TestFixture::width], d[TestFixture::width];
    spline_weights<TestFixture::order>(load(&places[n]), w);
    spline_derivatives<TestFixture::order>(load(&places[n]), d);
    for (int lane = 0; lane < n_lanes; ++lane) {
      double w_one[TestFixture::width], d_one[TestFixture::width];
      spline_weights<TestFixture::order>(places[n + static_cast<std::size_t>(lane)], w_one);
      spline_derivatives<TestFixture::order>(places[n + static_cast<std::size_t>(lane)], d_one);
      for (int k = 0; k < TestFixture::width; ++k) {
        EXPECT_EQ(w[k][lane], w_one[k]);
        EXPECT_EQ(d[k][lane], d_one[k]);
      }
    }
  }
}

// The bounds must hold, and be so close that they cost less than a bit of precision.
TYPED_TEST(Bspline, SumBoundsHoldAndAreClose) {
  constexpr int s = TestFixture::width, n_samples = 41;
  std::array<std::array<double, s>, n_samples> w, d;
  std::array<double, s> largest{};
  for (int n = 0; n < n_samples; ++n) {
    double w_n[s], d_n[s];
    const double fx = TestFixture::lowest + n / (n_samples - 1.0);
    spline_weights<TestFixture::order>(fx, w_n);
    spline_derivatives<TestFixture::order>(fx, d_n);
    for (int k = 0; k < s; ++k) {
      w[n][k] = w_n[k];
      d[n][k] = d_n[k];
      largest[k] = std::max(largest[k], w_n[k]);
    }
  }
  double weights = 0.0;
  for (const double value : largest) weights += value;
  weights = weights * weights * weights;
  EXPECT_LE(weights, weight_sum_bound(TestFixture::order));
  EXPECT_GT(weights, 0.995 * weight_sum_bound(TestFixture::order));

  // A node is node (i, j, k) of the stencils of width^3 base cells; in each, the particle may be at the worst place.
  double gradients = 0.0;
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j)
      for (int k = 0; k < s; ++k) {
        double steepest = 0.0;
        for (int a = 0; a < n_samples; ++a)
          for (int b = 0; b < n_samples; ++b)
            for (int c = 0; c < n_samples; ++c) {
              const double x = d[a][i] * w[b][j] * w[c][k], y = w[a][i] * d[b][j] * w[c][k], z = w[a][i] * w[b][j] * d[c][k];
              steepest = std::max(steepest, x * x + y * y + z * z);
            }
        gradients += std::sqrt(steepest);
      }
  const double bound = gradient_sum_ratio(TestFixture::order) * weight_sum_bound(TestFixture::order);
  EXPECT_LE(gradients, bound);
  EXPECT_GT(gradients, 0.85 * bound);
}

TYPED_TEST(Bspline, MomentSumRatioBounds) {
  constexpr SplineOrder degree = TestFixture::order;
  constexpr int s = stencil_width(degree), n_samples = 101;
  double w[n_samples][s], distance[n_samples][s];
  for (int a = 0; a < n_samples; ++a) {
    const double fx = TestFixture::lowest + static_cast<double>(a) / (n_samples - 1);
    double at[s];
    spline_weights<degree>(fx, at);
    for (int k = 0; k < s; ++k) {
      w[a][k] = at[k];
      distance[a][k] = k - fx;
    }
  }
  double moments = 0.0;
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j)
      for (int k = 0; k < s; ++k) {
        double largest = 0.0;
        for (int a = 0; a < n_samples; ++a)
          for (int b = 0; b < n_samples; ++b)
            for (int c = 0; c < n_samples; ++c)
              largest = std::max(largest,
                                 w[a][i] * w[b][j] * w[c][k] * std::hypot(distance[a][i], distance[b][j], distance[c][k]));
        moments += largest;
      }
  const double bound = moment_sum_ratio(degree) * weight_sum_bound(degree);
  EXPECT_LE(moments, bound);
  EXPECT_GT(moments, 0.99 * bound);
}

}  // namespace
}  // namespace bulkley::bspline_test
