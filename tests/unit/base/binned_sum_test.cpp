// Sums of any magnitudes that no order and no division changes, against exact ones.

#include "base/binned_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace bulkley::binned_sum_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double sum_of(const std::vector<double>& values) {
  BinnedSum sum;
  sum.add(values);
  return sum.value();
}

double dot_of(const std::vector<double>& a, const std::vector<double>& b) {
  BinnedSum sum;
  sum.add_products(a, b);
  return sum.value();
}

// The sum of finite numbers, rounded once: exact partial sums that do not overlap (Shewchuk 1997).
double exact_sum(const std::vector<double>& values) {
  std::vector<double> parts;
  for (double x : values) {
    std::size_t kept = 0;
    for (double y : parts) {
      if (std::abs(x) < std::abs(y)) std::swap(x, y);
      const double high = x + y, low = y - (high - x);
      if (low != 0.0) parts[kept++] = low;
      x = high;
    }
    parts.resize(kept);
    parts.push_back(x);
  }
  double sum = 0.0;
  for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
    const double before = sum;
    sum += *part;
    const double lost = *part - (sum - before);
    if (lost == 0.0) continue;
    if (auto next = part + 1; next != parts.rend() && (*next < 0.0) == (lost < 0.0)) {  // halfway: the rest decides
      const double twice = 2.0 * lost, up = sum + twice;
      if (twice == up - sum) sum = up;
    }
    break;
  }
  return sum;
}

// Numbers whose exponents lie between `lowest` and `highest`, of both signs.
std::vector<double> numbers(std::size_t count, double lowest, double highest, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> exponent(lowest, highest), mantissa(1.0, 2.0);
  std::vector<double> values(count);
  for (double& v : values) v = (generator() % 2 ? 1.0 : -1.0) * std::ldexp(mantissa(generator), int(exponent(generator)));
  return values;
}

struct Case {
  const char* name;
  std::vector<double> values;
};

std::vector<double> with_opposites(std::vector<double> values, double rest) {
  const std::size_t n = values.size();
  for (std::size_t i = 0; i < n; ++i) values.push_back(-values[i]);
  values.push_back(rest);
  return values;
}

std::vector<Case> cases() {
  return {{"like numbers", numbers(5000, -1.0, 1.0, 1)},
          {"1e-300 to 1e300", numbers(5000, -996.0, 996.0, 2)},
          {"up to the largest", numbers(3000, 1000.0, 1019.0, 3)},
          {"across the first scaled bin", numbers(5000, 750.0, 900.0, 4)},
          {"down to subnormals", numbers(5000, -1074.0, -960.0, 5)},
          {"subnormals only", numbers(5000, -1074.0, -1023.0, 6)},
          {"cancellation", with_opposites(numbers(5000, -10.0, 10.0, 7), 1e-9)},
          {"cancellation of the largest", with_opposites(numbers(3000, 1000.0, 1023.0, 8), 1e290)},
          {"a few", numbers(3, -5.0, 5.0, 9)},
          {"blocks of 1024 and one", numbers(1025, -5.0, 5.0, 10)},
          {"powers of two", {1.0, 0x1p-53, 0x1p-53, -1.0, 0x1p39, 0x1p40, -0x1p40, 0x1p-1074, 0x1p-79, 0x1p-80}}};
}

TEST(BinnedSum, HasTheSameBitsInAnyOrder) {
  std::mt19937 random(11);
  for (Case test : cases()) {
    SCOPED_TRACE(test.name);
    const double expected = sum_of(test.values);
    for (int round = 0; round < 20; ++round) {
      std::shuffle(test.values.begin(), test.values.end(), random);
      EXPECT_EQ(std::bit_cast<std::uint64_t>(sum_of(test.values)), std::bit_cast<std::uint64_t>(expected));
    }
    std::sort(test.values.begin(), test.values.end());
    EXPECT_EQ(sum_of(test.values), expected);
    std::reverse(test.values.begin(), test.values.end());
    EXPECT_EQ(sum_of(test.values), expected);
  }
}

TEST(BinnedSum, HasTheSameBitsHoweverItIsDivided) {
  std::mt19937 random(12);
  for (const Case& test : cases()) {
    SCOPED_TRACE(test.name);
    const double expected = sum_of(test.values);
    for (const std::size_t n_parts : {2, 3, 17}) {
      std::vector<std::vector<double>> parts(n_parts);
      for (const double v : test.values) parts[random() % n_parts].push_back(v);
      std::vector<BinnedSum> sums(n_parts);
      for (std::size_t part = 0; part < n_parts; ++part) sums[part].add(parts[part]);
      std::shuffle(sums.begin(), sums.end(), random);
      BinnedSum total;
      for (const BinnedSum& sum : sums) total.merge(sum);
      EXPECT_EQ(std::bit_cast<std::uint64_t>(total.value()), std::bit_cast<std::uint64_t>(expected));
    }
    BinnedSum one_by_one;
    for (const double v : test.values) one_by_one.add({&v, 1});
    EXPECT_EQ(one_by_one.value(), expected);
  }
}

TEST(BinnedSum, IsAsAccurateAsPromised) {
  for (const Case& test : cases()) {
    SCOPED_TRACE(test.name);
    double largest = 0.0;
    for (const double v : test.values) largest = std::max(largest, std::abs(v));
    // Exact sums of the largest numbers would overflow on the way.
    const double scale = largest > 1e200 ? 0x1p-100 : 1.0;
    std::vector<double> scaled = test.values;
    for (double& v : scaled) v *= scale;
    const double exact = exact_sum(scaled), found = sum_of(test.values) * scale;
    EXPECT_LE(std::abs(found - exact),
              static_cast<double>(scaled.size()) * 0x1p-80 * (largest * scale) + 0x1p-53 * std::abs(exact) + 0x1p-1074);
    // No worse than a plain loop may be.
    double plain_error = 0.0;
    for (const double v : scaled) plain_error += static_cast<double>(scaled.size()) * 0x1p-53 * std::abs(v);
    EXPECT_LE(std::abs(found - exact), plain_error + 0x1p-1074);
  }
}

// Numbers within 80 bits of the largest are summed exactly, and the sum is rounded to nearest, ties to even.
TEST(BinnedSum, IsRoundedOnce) {
  EXPECT_EQ(sum_of({1.0, 0x1p-53}), 1.0);
  EXPECT_EQ(sum_of({1.0, 0x1p-53, 0x1p-70}), 1.0 + 0x1p-52);
  EXPECT_EQ(sum_of({1.0 + 0x1p-52, 0x1p-53}), 1.0 + 0x1p-51);
  EXPECT_EQ(sum_of({-1.0, -0x1p-53, -0x1p-70}), -1.0 - 0x1p-52);
  EXPECT_EQ(sum_of({1e16, 1.0, -1e16}), 1.0);
  EXPECT_EQ(sum_of({-0x1p40, 0x1p39, 0x1p39, 3.0}), 3.0);
  // Halfway between two doubles far above the lowest bin, which then decides.
  std::vector<double> large(1024, 0x1p38);
  large.push_back(0x1p-5);
  EXPECT_EQ(sum_of(large), 0x1p48);
  large.push_back(0x1p-70);
  EXPECT_EQ(sum_of(large), 0x1p48 + 0x1p-4);
  large.back() = -0x1p-70;
  EXPECT_EQ(sum_of(large), 0x1p48);
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::vector<double> values = numbers(2000, -4.0, 4.0, seed);  // multiples of 2^-56
    EXPECT_EQ(sum_of(values), exact_sum(values));
    std::vector<double> many;  // more than 2^46 quanta of the first bin
    for (int k = 0; k < 300; ++k) many.insert(many.end(), values.begin(), values.end());
    for (double& v : many) v = std::abs(v) + 0x1p38;
    EXPECT_EQ(sum_of(many), exact_sum(many));
    if (seed > 3) continue;
    for (double& v : many) v = -v;
    EXPECT_EQ(sum_of(many), exact_sum(many));
  }
}

TEST(BinnedSum, ZerosArePositive) {
  for (const std::vector<double>& values : {std::vector<double>{},
                                            {0.0},
                                            {-0.0},
                                            {-0.0, -0.0, 0.0},
                                            {1.0, -1.0},
                                            {-1e300, 1e300, -0.0},
                                            {0x1p-1074, -0x1p-1074}}) {
    EXPECT_EQ(sum_of(values), 0.0);
    EXPECT_FALSE(std::signbit(sum_of(values)));
  }
}

TEST(BinnedSum, PassesOnWhatIsNotFinite) {
  for (const std::size_t at : {0, 5, 1023, 1024, 2999}) {
    for (const double filler : {0.0, 1.0, 1e-310, 1e308}) {
      std::vector<double> values(3000, filler);
      values[at] = infinity;
      EXPECT_EQ(sum_of(values), infinity);
      values[at] = -infinity;
      EXPECT_EQ(sum_of(values), -infinity);
      values[(at + 1700) % 3000] = infinity;
      EXPECT_TRUE(std::isnan(sum_of(values)));
      values[(at + 1700) % 3000] = filler;
      values[at] = nan;
      EXPECT_TRUE(std::isnan(sum_of(values))) << at << " " << filler;
    }
  }
  BinnedSum infinite, finite;
  infinite.add(std::vector{infinity});
  finite.add(std::vector{1.0});
  finite.merge(infinite);
  EXPECT_EQ(finite.value(), infinity);
}

TEST(BinnedSum, OverflowsOnlyAtTheEnd) {
  EXPECT_EQ(sum_of({1e308, 1e308, -1e308}), 1e308);
  EXPECT_EQ(sum_of({1e308, 1e308}), infinity);
  EXPECT_EQ(sum_of({-1e308, -1e308}), -infinity);
  std::vector<double> alternating;
  for (int i = 0; i < 5000; ++i) alternating.push_back(i < 2500 ? 1.7e308 : -1.7e308);
  alternating.push_back(0x1p960);
  EXPECT_EQ(sum_of(alternating), 0x1p960);
}

TEST(BinnedSum, ProductsAreThoseOfDoubles) {
  const std::vector<double> a = numbers(5000, -500.0, 500.0, 20), b = numbers(5000, -500.0, 500.0, 21);
  std::vector<double> products(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) products[i] = a[i] * b[i];
  EXPECT_EQ(dot_of(a, b), sum_of(products));
  EXPECT_EQ(dot_of({1e200, 1.0}, {1e200, 1.0}), infinity);
  EXPECT_EQ(dot_of({1e-200, 1.0}, {1e-200, 1.0}), 1.0);
  EXPECT_TRUE(std::isnan(dot_of({0.0, 1.0}, {infinity, 1.0})));
}

// What is taken away again leaves exactly what was there, and words carry every bit.
TEST(BinnedSum, SubtractsAndTravelsAsWords) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<double> small, large;
  for (int i = 0; i < 3000; ++i) {
    small.push_back(normal(random));
    large.push_back(1e6 * normal(random));
  }
  BinnedSum sum, taken;
  sum.add(large);
  sum.add(small);
  taken.add(large);
  sum.subtract(taken);
  EXPECT_NEAR(sum.value(), exact_sum(small), 3000.0 * 0x1p-80 * 5e6);
  EXPECT_NE(taken.value(), 0.0);
  taken.subtract(taken);
  EXPECT_EQ(taken.value(), 0.0);

  const auto words = sum.words();
  const BinnedSum again = BinnedSum::of_words(words);
  EXPECT_EQ(again.value(), sum.value());
  EXPECT_EQ(again.words(), words);
  for (const double special : {infinity, -infinity, nan}) {
    BinnedSum other;
    other.add(std::vector<double>{1.0, special});
    EXPECT_EQ(BinnedSum::of_words(other.words()).words(), other.words());
    EXPECT_EQ(std::isnan(BinnedSum::of_words(other.words()).value()), std::isnan(special));
  }
  const auto none = BinnedSum{}.words();
  EXPECT_TRUE(std::all_of(none.begin(), none.end(), [](std::int64_t word) { return word == 0; }));
}

}  // namespace
}  // namespace bulkley::binned_sum_test
