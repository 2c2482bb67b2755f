#include "bulkley/base/pack_pair.hpp"

#include <gtest/gtest.h>

#include "bulkley/base/pack_math.hpp"

namespace bulkley {
namespace {

Pack ramp(double first, double step) {
  Pack pack;
  for (int lane = 0; lane < n_lanes; ++lane) pack[lane] = first + step * lane;
  return pack;
}

const PackPair a{ramp(-3.25, 1.1), ramp(0.5, 2.0)}, b{ramp(2.0, -0.7), ramp(3.0, 0.3)};

bool equal(const PackPair& x, const Pack& first, const Pack& second) {
  return !any(x.first != first) && !any(x.second != second);
}
bool equal(const Pair<PackMask>& x, const PackMask& first, const PackMask& second) {
  return !any(x.first != first) && !any(x.second != second);
}

TEST(PackPair, OperatesOnBothHalves) {
  EXPECT_TRUE(equal(a + b, a.first + b.first, a.second + b.second));
  EXPECT_TRUE(equal(a - b, a.first - b.first, a.second - b.second));
  EXPECT_TRUE(equal(a * b, a.first * b.first, a.second * b.second));
  EXPECT_TRUE(equal(a / b, a.first / b.first, a.second / b.second));
  EXPECT_TRUE(equal(-a, -a.first, -a.second));
  EXPECT_TRUE(equal(2.0 - a, 2.0 - a.first, 2.0 - a.second));
  EXPECT_TRUE(equal(a - 2.0, a.first - 2.0, a.second - 2.0));
  PackPair c = a;
  c += b;
  c -= 1.0;
  c *= a;
  EXPECT_TRUE(equal(c, (a.first + b.first - 1.0) * a.first, (a.second + b.second - 1.0) * a.second));
  EXPECT_TRUE(equal(broadcast<PackPair>(7.5), ramp(7.5, 0.0), ramp(7.5, 0.0)));
}

TEST(PackPair, ComparesAndSelectsLaneByLane) {
  EXPECT_TRUE(equal(a < b, a.first < b.first, a.second < b.second));
  EXPECT_TRUE(equal(a > b, a.first > b.first, a.second > b.second));
  EXPECT_TRUE(equal(a <= a, a.first == a.first, a.second == a.second));
  EXPECT_TRUE(equal(a >= b, a.first >= b.first, a.second >= b.second));
  EXPECT_TRUE(equal(a == b, a.first == b.first, a.second == b.second));
  EXPECT_TRUE(equal((a < b) & (b > 1.0), (a.first < b.first) & (b.first > 1.0), (a.second < b.second) & (b.second > 1.0)));
  EXPECT_TRUE(equal(minimum(a, b), minimum(a.first, b.first), minimum(a.second, b.second)));
  EXPECT_TRUE(equal(maximum(a, b), maximum(a.first, b.first), maximum(a.second, b.second)));
  EXPECT_TRUE(equal(absolute(a), absolute(a.first), absolute(a.second)));
}

TEST(PackPair, AnySeesEachSingleLane) {
  EXPECT_FALSE(any(Pair<PackMask>{}));
  for (int lane = 0; lane < n_lanes; ++lane) {
    PackMask mask{};
    mask[lane] = -1;
    EXPECT_TRUE(any(Pair<PackMask>{mask, PackMask{}})) << lane;
    EXPECT_TRUE(any(Pair<PackMask>{PackMask{}, mask})) << lane;
  }
}

TEST(PackPair, FunctionsAreThoseOfItsHalves) {
  const PackPair positive{ramp(0.0, 0.37), ramp(5.0, 3.0)};
  EXPECT_TRUE(equal(square_root(positive), square_root(positive.first), square_root(positive.second)));
  EXPECT_TRUE(equal(exponential(a), exponential(a.first), exponential(a.second)));
  EXPECT_TRUE(equal(logarithm(positive), logarithm(positive.first), logarithm(positive.second)));
  const PackPair large = positive + 1.0;
  EXPECT_TRUE(equal(inverse_cube_root(large), inverse_cube_root(large.first), inverse_cube_root(large.second)));
}

}  // namespace
}  // namespace bulkley
