#include "bulkley/base/pack.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bulkley::pack_test {
namespace {

Pack ramp(double first, double step) {
  Pack pack;
  for (int lane = 0; lane < n_lanes; ++lane) pack[lane] = first + step * lane;
  return pack;
}

TEST(Pack, LoadAndStoreNeedNoAlignment) {
  double from[n_lanes + 1], to[n_lanes + 1] = {};
  for (int i = 0; i <= n_lanes; ++i) from[i] = i + 0.5;
  store(to + 1, load(from + 1));
  EXPECT_EQ(to[0], 0.0);
  for (int i = 1; i <= n_lanes; ++i) EXPECT_EQ(to[i], from[i]);
}

TEST(Pack, AnySeesEachSingleLane) {
  EXPECT_FALSE(any(PackMask{}));
  for (int lane = 0; lane < n_lanes; ++lane) {
    PackMask mask{};
    mask[lane] = -1;
    EXPECT_TRUE(any(mask)) << lane;
  }
}

TEST(Pack, LanewiseFunctionsAgreeWithTheirScalars) {
  const Pack a = ramp(-3.25, 1.1), b = ramp(2.0, -0.7), positive = ramp(0.0, 0.37);
  for (int lane = 0; lane < n_lanes; ++lane) {
    EXPECT_EQ(select(a < b, a, b)[lane], select(a[lane] < b[lane], a[lane], b[lane]));
    EXPECT_EQ(minimum(a, b)[lane], std::fmin(a[lane], b[lane]));
    EXPECT_EQ(maximum(a, b)[lane], std::fmax(a[lane], b[lane]));
    EXPECT_EQ(absolute(a)[lane], std::fabs(a[lane]));
    EXPECT_EQ(round_down(a)[lane], std::floor(a[lane]));
    EXPECT_EQ(square_root(positive)[lane], std::sqrt(positive[lane]));
    EXPECT_EQ(broadcast<Pack>(7.5)[lane], 7.5);
  }
}

TEST(Pack, GathersOneNumberForEachLane) {
  double table[5 * n_lanes];
  for (int i = 0; i < 5 * n_lanes; ++i) table[i] = 100.0 + i;
  PackMask index;
  for (int lane = 0; lane < n_lanes; ++lane) index[lane] = (7 * lane + 3) % (5 * n_lanes);
  for (int lane = 0; lane < n_lanes; ++lane) EXPECT_EQ(gather(table, index)[lane], gather(table, std::int64_t{index[lane]}));
  EXPECT_EQ(gather(table, std::int64_t{3}), 103.0);
}

TEST(Pack, ComparisonsWithNaNAreFalse) {
  const Pack nan = broadcast<Pack>(std::nan("")), one = broadcast<Pack>(1.0);
  EXPECT_FALSE(any(nan < one) || any(nan > one) || any(nan == nan));
}

}  // namespace
}  // namespace bulkley::pack_test
