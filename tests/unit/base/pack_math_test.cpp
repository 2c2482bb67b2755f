// Reference: the 80-bit functions of the C library.

#include "bulkley/base/pack_math.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace bulkley::pack_math_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double smallest_subnormal = std::numeric_limits<double>::denorm_min();
constexpr double largest = std::numeric_limits<double>::max();

double ulp(double x) { return std::nextafter(std::fabs(x), infinity) - std::fabs(x); }

double error_in_ulp(double value, long double exact) {
  return static_cast<double>(std::fabs(value - exact)) / ulp(static_cast<double>(exact));
}

Pack apply(Pack (*function)(Pack), double x) { return function(broadcast<Pack>(x)); }

// Every value also goes through Pack, which must give the same bits.
template <class Sample>
double worst_error(double (*function)(double), Pack (*lanes)(Pack), long double (*exact)(long double), Sample sample) {
  std::mt19937_64 random(42);
  double worst = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double x = sample(random);
    const double y = function(x);
    worst = std::max(worst, error_in_ulp(y, exact(x)));
    EXPECT_EQ(to_bits(apply(lanes, x)[i % n_lanes]), to_bits(y)) << x;
  }
  return worst;
}

auto uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to); }
auto magnitudes(double from, double to) {
  return [u = uniform(from, to)](auto& random) mutable { return std::exp2(u(random)); };
}

long double exact_exponential(long double x) { return std::exp(x); }
long double exact_logarithm(long double x) { return std::log(x); }
long double exact_inverse_cube_root(long double x) { return 1.0L / std::cbrt(x); }

TEST(Exponential, IsWithinTwoUlp) {
  const auto worst = [](auto sample) {
    return worst_error(exponential<double>, exponential<Pack>, exact_exponential, sample);
  };
  EXPECT_LE(worst(uniform(-1.0, 1.0)), 2.0);
  EXPECT_LE(worst(uniform(-40.0, 40.0)), 2.0);
  EXPECT_LE(worst(uniform(-708.39, 709.78)), 2.0);
}

TEST(Exponential, Extremes) {
  EXPECT_EQ(exponential(0.0), 1.0);
  EXPECT_EQ(exponential(-0.0), 1.0);
  EXPECT_EQ(exponential(smallest_subnormal), 1.0);
  EXPECT_LE(error_in_ulp(exponential(709.78), exact_exponential(709.78)), 2.0);
  EXPECT_LE(error_in_ulp(exponential(-708.39), exact_exponential(-708.39)), 2.0);
  EXPECT_EQ(exponential(709.79), infinity);
  EXPECT_EQ(exponential(1e300), infinity);
  EXPECT_EQ(exponential(infinity), infinity);
  EXPECT_EQ(exponential(-708.4), 0.0);
  EXPECT_EQ(exponential(-1e300), 0.0);
  EXPECT_EQ(exponential(-infinity), 0.0);
  EXPECT_TRUE(std::isnan(exponential(nan_value)));
}

TEST(Logarithm, IsWithinTwoUlp) {
  const auto worst = [](auto sample) { return worst_error(logarithm<double>, logarithm<Pack>, exact_logarithm, sample); };
  EXPECT_LE(worst(uniform(0.5, 2.0)), 2.0);
  EXPECT_LE(worst(uniform(0.999999, 1.000001)), 2.0);
  EXPECT_LE(worst(magnitudes(-1022.0, 1023.9)), 2.0);
  EXPECT_LE(worst(magnitudes(-1070.0, -1022.0)), 2.0);
}

TEST(Logarithm, Extremes) {
  EXPECT_EQ(logarithm(1.0), 0.0);
  EXPECT_EQ(logarithm(0.0), -infinity);
  EXPECT_EQ(logarithm(-0.0), -infinity);
  EXPECT_EQ(logarithm(infinity), infinity);
  EXPECT_LE(error_in_ulp(logarithm(smallest_subnormal), std::log(static_cast<long double>(smallest_subnormal))), 2.0);
  EXPECT_LE(error_in_ulp(logarithm(largest), std::log(static_cast<long double>(largest))), 2.0);
  EXPECT_TRUE(std::isnan(logarithm(-1.0)));
  EXPECT_TRUE(std::isnan(logarithm(-infinity)));
  EXPECT_TRUE(std::isnan(logarithm(nan_value)));
}

TEST(InverseCubeRoot, IsWithinTwoUlp) {
  const auto worst = [](auto sample) {
    return worst_error(inverse_cube_root<double>, inverse_cube_root<Pack>, exact_inverse_cube_root, sample);
  };
  EXPECT_LE(worst(uniform(0.9, 1.1)), 2.0);
  EXPECT_LE(worst(magnitudes(-3.0, 3.0)), 2.0);
  EXPECT_LE(worst(magnitudes(-1022.0, 1023.9)), 2.0);
}

TEST(InverseCubeRoot, IsExactForOneAndRefusesWhatHasNone) {
  EXPECT_EQ(inverse_cube_root(1.0), 1.0);
  EXPECT_EQ(inverse_cube_root(8.0), 0.5);
  for (const double x : {0.0, -1.0, smallest_subnormal, infinity, -infinity, nan_value})
    EXPECT_TRUE(std::isnan(inverse_cube_root(x))) << x;
}

TEST(Power, IsWithinItsStatedError) {
  std::mt19937_64 random(7);
  auto base = magnitudes(-60.0, 60.0);
  auto exponent = uniform(-10.0, 10.0);
  for (int i = 0; i < 100000; ++i) {
    const double x = base(random), y = exponent(random);
    const long double log_result = y * std::log(static_cast<long double>(x));
    if (std::fabs(log_result) > 700.0L) continue;
    EXPECT_LE(error_in_ulp(power(x, y), std::exp(log_result)), 2.0 + 2.0 * static_cast<double>(std::fabs(log_result)));
  }
}

// One source for every lane: what the other lanes hold must not matter.
TEST(PackMath, LanesAreIndependent) {
  const double values[] = {0.0, -1.0, 1e-310, 1e300, infinity, nan_value, 0.3, 17.0};
  for (const double x : values) {
    for (int lane = 0; lane < n_lanes; ++lane) {
      Pack pack;
      for (int i = 0; i < n_lanes; ++i) pack[i] = values[(i + lane) % 8];
      pack[lane] = x;
      EXPECT_EQ(to_bits(double{exponential(pack)[lane]}), to_bits(exponential(x)));
      EXPECT_EQ(to_bits(double{logarithm(pack)[lane]}), to_bits(logarithm(x)));
      EXPECT_EQ(std::isnan(inverse_cube_root(pack)[lane]), std::isnan(inverse_cube_root(x)));
    }
  }
}

}  // namespace
}  // namespace bulkley::pack_math_test
