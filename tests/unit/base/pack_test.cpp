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

TEST(Pack, TransposesQuadsToRowsAndBack) {
  Quad quads[n_lanes], back[n_lanes];
  for (int lane = 0; lane < n_lanes; ++lane)
    for (int r = 0; r < 4; ++r) quads[lane][r] = 10.0 * lane + r;
  Pack rows[4];
  transpose_quads([&](int lane) { return quads[lane]; }, rows);
  transpose_rows(rows, [&](int lane, Quad quad) { back[lane] = quad; });
  for (int lane = 0; lane < n_lanes; ++lane)
    for (int r = 0; r < 4; ++r) {
      EXPECT_EQ(rows[r][lane], 10.0 * lane + r);
      EXPECT_EQ(back[lane][r], 10.0 * lane + r);
    }
}

TEST(Pack, GathersFourNumbersForEachLane) {
  double table[5 * n_lanes + 3];
  for (int i = 0; i < 5 * n_lanes + 3; ++i) table[i] = 100.0 + i;
  PackMask index;
  for (int lane = 0; lane < n_lanes; ++lane) index[lane] = (7 * lane + 3) % (5 * n_lanes);
  Pack rows[4];
  gather_rows(table, index, rows);
  for (int lane = 0; lane < n_lanes; ++lane) {
    double row[4];
    gather_rows(table, std::int64_t{index[lane]}, row);
    for (int r = 0; r < 4; ++r) {
      EXPECT_EQ(row[r], 100.0 + static_cast<double>(index[lane]) + r);
      EXPECT_EQ(rows[r][lane], row[r]);
    }
  }
}

TEST(Pack, ComparisonsWithNaNAreFalse) {
  const Pack nan = broadcast<Pack>(std::nan("")), one = broadcast<Pack>(1.0);
  EXPECT_FALSE(any(nan < one) || any(nan > one) || any(nan == nan));
}

}  // namespace
}  // namespace bulkley::pack_test
