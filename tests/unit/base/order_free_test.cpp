// Rounded addends make sums that no order changes (docs/theory.md, "Order-free sums").

#include "base/order_free.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "bulkley/base/pack.hpp"

namespace bulkley::order_free_test {
namespace {

const double bounds[] = {1e-250, 3e-20, 0.5, std::nextafter(1.0, 0.0), 1.0, 5.0, 1e6, 1e250};

// Values of all sizes and both signs whose absolute values sum to at most `bound`, and nearly to it.
std::vector<double> values_within(double bound, std::size_t count, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> exponent(-60.0, 0.0);
  std::vector<double> values(count);
  double sum = 0.0;
  for (double& v : values) {
    v = std::exp2(exponent(generator));
    sum += v;
  }
  for (std::size_t n = 0; n < count; ++n) values[n] *= (n % 2 ? -1.0 : 1.0) * bound / sum * (1.0 - 1e-12);
  return values;
}

double sum_of_rounded(const std::vector<double>& values, double constant) {
  double sum = 0.0;
  for (const double v : values) sum += rounded(v, constant);
  return sum;
}

TEST(OrderFree, RoundsToTheNearestMultipleOfTheQuantum) {
  for (const double bound : bounds) {
    const double constant = rounding_constant(bound), quantum = rounding_quantum(bound);
    EXPECT_LE(quantum, bound * 0x1p-52) << bound;
    for (double v : values_within(bound, 2000, 1)) {
      const double r = rounded(v, constant);
      EXPECT_LE(std::abs(r - v), 0.5 * quantum) << bound;
      EXPECT_EQ(r / quantum, std::nearbyint(r / quantum)) << bound;
      EXPECT_EQ(rounded(r, constant), r) << bound;
    }
    const double largest = 0.25 * bound;  // of one addend
    EXPECT_LE(std::abs(rounded(largest, constant) - largest), 0.5 * quantum);
    EXPECT_LE(std::abs(rounded(-largest, constant) + largest), 0.5 * quantum);
    EXPECT_EQ(rounded(0.49 * quantum, constant), 0.0);
  }
}

TEST(OrderFree, NoOrderChangesTheBitsOfASum) {
  for (const double bound : bounds) {
    const double constant = rounding_constant(bound);
    std::vector<double> values = values_within(bound, 5000, 2);
    const double sum = sum_of_rounded(values, constant);
    double plain = 0.0;
    for (const double v : values) plain += v;
    int n_plain_differs = 0;
    std::mt19937 generator(3);
    for (int trial = 0; trial < 20; ++trial) {
      std::shuffle(values.begin(), values.end(), generator);
      EXPECT_EQ(sum_of_rounded(values, constant), sum) << bound;
      double again = 0.0;
      for (const double v : values) again += v;
      n_plain_differs += again != plain;
    }
    EXPECT_GT(n_plain_differs, 0) << "these values would not show a dependence on the order";
    // All of one sign, in ascending and descending order: the largest partial sums there are.
    for (double& v : values) v = std::abs(v);
    std::sort(values.begin(), values.end());
    const double ascending = sum_of_rounded(values, constant);
    std::reverse(values.begin(), values.end());
    EXPECT_EQ(sum_of_rounded(values, constant), ascending) << bound;
  }
}

// Every addend just above half a quantum is rounded up: the sum of the rounded ones is twice that of the addends.
TEST(OrderFree, SumsOfAddendsThatAllRoundUpStayExact) {
  const double bound = 1.0, constant = rounding_constant(bound), quantum = rounding_quantum(bound);
  const double largest = rounded(0.25, constant);
  double sum = largest;
  for (int n = 0; n < 100000; ++n) sum += rounded(0.51 * quantum, constant);
  EXPECT_EQ(sum, largest + 100000 * quantum);
}

TEST(OrderFree, NothingButZerosIsAValidSum) {
  EXPECT_EQ(rounded(0.0, rounding_constant(0.0)), 0.0);
  EXPECT_FALSE(std::signbit(rounded(0.0, rounding_constant(0.0))));
}

TEST(OrderFree, PackLanesAreTheScalarBits) {
  for (const double bound : bounds) {
    const double constant = rounding_constant(bound);
    const std::vector<double> values = values_within(bound, n_lanes, 4);
    const Pack packed = rounded(load(values.data()), broadcast<Pack>(constant));
    for (int lane = 0; lane < n_lanes; ++lane)
      EXPECT_EQ(packed[lane], rounded(values[static_cast<std::size_t>(lane)], constant));
  }
}

}  // namespace
}  // namespace bulkley::order_free_test
