// The profile of an inflow: shares against closed forms and finite differences, columns that move at their own speeds, the flow of nodes.
#include "particle/feed_profile.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <set>

#include "particle/inflow.hpp"

namespace bulkley::feed_profile_test {
namespace {

constexpr OpenEnds walled{};
constexpr OpenEnds open_height{{{false, false}, {true, true}}};

double mean_of(const SpeedShares& shares, const RectangleSection& section) {
  constexpr int n = 200;
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      sum += shares.at(((i + 0.5) / n - 0.5) * section.width, ((j + 0.5) / n - 0.5) * section.height).value;
  return sum / (n * n);
}

TEST(SpeedShares, OfADiscAreAParabolaOfMeanOne) {
  const SpeedShares shares(DiscSection{0.03});
  EXPECT_DOUBLE_EQ(shares.at(0.0, 0.0).value, 2.0);
  EXPECT_DOUBLE_EQ(shares.at(0.018, 0.024 / 2.0).value, 2.0 * (1.0 - 0.36 - 0.16));
  EXPECT_EQ(shares.at(0.03, 0.001).value, 0.0);
  EXPECT_EQ(shares.at(0.03, 0.001).slope[0], 0.0);
  EXPECT_EQ(shares.largest(), 2.0);
}

TEST(SpeedShares, OfADuctAreThoseOfTheLiterature) {
  // White, Viscous Fluid Flow: the largest speed over the mean.
  EXPECT_NEAR(SpeedShares(RectangleSection{0.02, 0.02}, walled).largest(), 2.0963, 1e-4);
  EXPECT_NEAR(SpeedShares(RectangleSection{0.04, 0.02}, walled).largest(), 1.9918, 1e-4);
  EXPECT_NEAR(SpeedShares(RectangleSection{0.02, 20.0}, walled).largest(), 1.5, 1e-3);
}

TEST(SpeedShares, SolveTheEquationOfDevelopedFlow) {
  const double h = 1e-5;
  for (const RectangleSection section :
       {RectangleSection{0.02, 0.02}, RectangleSection{0.02, 0.05}, RectangleSection{0.05, 0.02}}) {
    const SpeedShares shares(section, walled);
    EXPECT_NEAR(mean_of(shares, section), 1.0, 5e-5) << "by 200 points a side";
    double first = 0.0;
    for (const double a : {0.0, 0.1, -0.3, 0.45})
      for (const double b : {0.0, -0.2, 0.4}) {
        const double x = a * section.width, y = b * section.height, middle = shares.at(x, y).value;
        const double left = shares.at(x - h, y).value, right = shares.at(x + h, y).value;
        const double below = shares.at(x, y - h).value, above = shares.at(x, y + h).value;
        const double laplacian = (left + right + below + above - 4.0 * middle) / (h * h);
        if (first == 0.0) first = laplacian;
        EXPECT_NEAR(laplacian / first, 1.0, 1e-4) << "a constant, the pressure gradient";
        EXPECT_NEAR(shares.at(x, y).slope[0], 0.5 * (right - left) / h, 1e-3);
        EXPECT_NEAR(shares.at(x, y).slope[1], 0.5 * (above - below) / h, 1e-3);
      }
    for (const double part : {-0.5, -0.25, 0.0, 0.4}) {
      EXPECT_NEAR(shares.at(part * section.width, 0.5 * section.height * (1.0 - 1e-6)).value, 0.0, 1e-4);
      EXPECT_EQ(shares.at(part * section.width, 0.51 * section.height).value, 0.0);
    }
  }
}

TEST(SpeedShares, BetweenOpenEndsAreThoseOfPlanes) {
  const RectangleSection section{0.02, 0.01};
  const SpeedShares plane(section, open_height);
  EXPECT_DOUBLE_EQ(plane.at(0.005, 0.3).value, 1.5 * 0.75);
  EXPECT_DOUBLE_EQ(plane.at(0.005, 0.0).slope[0], -150.0);
  EXPECT_EQ(plane.at(0.005, 0.0).slope[1], 0.0);
  EXPECT_EQ(plane.largest(), 1.5);
  // With one open end, a half of what is twice as wide.
  const SpeedShares half(section, OpenEnds{{{true, false}, {true, true}}});
  EXPECT_DOUBLE_EQ(half.at(-0.01, 0.0).value, 1.5);
  EXPECT_DOUBLE_EQ(half.at(0.0, 0.0).value, 1.5 * 0.75);
  EXPECT_NEAR(mean_of(half, section), 1.0, 1e-5);
  const SpeedShares quarter(section, OpenEnds{{{false, true}, {true, false}}});
  const SpeedShares whole(RectangleSection{0.04, 0.02}, walled);
  EXPECT_NEAR(quarter.at(0.0, 0.0).value, whole.at(-0.01, 0.005).value, 1e-14);
  EXPECT_TRUE(SpeedShares(section, OpenEnds{{{true, true}, {true, true}}}).is_plug());
}

GridGeometry grid() {
  GridGeometry g;
  g.cell_size = 0.01;
  g.n_cells = {20, 20, 20};
  return g;
}

TEST(OpenEnds, AreThoseOnSlipAndPeriodicFaces) {
  const auto ends_of = [](FaceKind lower, FaceKind upper, const Vec3& center, double width,
                          const Vec3& first = Vec3::UnitY()) {
    Faces faces;
    faces[2].kind = lower;
    faces[3].kind = upper;
    return open_ends(grid(), faces, RectangleSection{width, 0.05}, center, first, first.cross(-Vec3::UnitX()));
  };
  constexpr OpenEnds both{{{true, true}, {false, false}}}, lower{{{true, false}, {false, false}}},
      upper{{{false, true}, {false, false}}};
  const Vec3 middle(0.1, 0.1, 0.1);
  EXPECT_EQ(ends_of(FaceKind::periodic, FaceKind::periodic, middle, 0.2), both);
  EXPECT_EQ(ends_of(FaceKind::slip, FaceKind::slip, middle, 0.2), both);
  EXPECT_EQ(ends_of(FaceKind::slip, FaceKind::sticky, middle, 0.2), lower);
  EXPECT_EQ(ends_of(FaceKind::slip, FaceKind::sticky, middle, 0.2, -Vec3::UnitY()), upper);
  EXPECT_EQ(ends_of(FaceKind::sticky, FaceKind::sticky, middle, 0.2), walled);
  EXPECT_EQ(ends_of(FaceKind::slip, FaceKind::slip, middle, 0.1), walled);
  const Vec3 low(0.1, 0.05, 0.1);
  EXPECT_EQ(ends_of(FaceKind::slip, FaceKind::slip, low, 0.1), lower);
  EXPECT_EQ(ends_of(FaceKind::periodic, FaceKind::periodic, low, 0.1), walled) << "the section does not go on there";
  EXPECT_EQ(ends_of(FaceKind::slip, FaceKind::slip, middle, 0.2, Vec3(0.0, 0.8, 0.6)), walled);
}

Inflow jet(double radius = 0.03) {
  Inflow inflow;
  inflow.section = DiscSection{radius};
  inflow.position = Vec3(0.1031, 0.0983, 0.15);
  inflow.speed = TimeFormula{0.5, ""};
  inflow.density = 1000.0;
  inflow.profile = FeedProfile::poiseuille;
  return inflow;
}

TEST(FeedWithAProfile, EntersAtTheRightRate) {
  for (const double radius : {0.0201, 0.03, 0.047}) {
    const Feed feed(grid(), jet(radius), 0, 10.0);
    double shares = 0.0;
    for (const Feed::Point& point : feed.points()) shares += point.share;
    EXPECT_NEAR(shares * feed.particle_volume() / (area(DiscSection{radius}) * feed.layer_height()), 1.0, 1e-13);
    const double layer = area(DiscSection{radius}) * feed.layer_height();
    double entered_before = 0.0;
    for (double t = 0.0; t < 6.0; t += 0.00137) {  // 600 layers
      const double entered = static_cast<double>(feed.n_particles(feed.released(t))) * feed.particle_volume();
      ASSERT_GE(entered, entered_before);
      ASSERT_LE(std::abs(entered - feed.entered_volume(t)), 0.17 * layer) << radius << ", " << t;
      if (t > 1.7) {
        ASSERT_NEAR(entered / feed.entered_volume(t), 1.0, 1e-3) << radius << ", " << t;
      }
      entered_before = entered;
    }
  }
}

TEST(FeedWithAProfile, HasColumnsWithoutGapsOrOverlaps) {
  const Feed feed(grid(), jet(), 3 * Feed::ids_per_inflow, 10.0);
  for (const double t : {0.0, 0.0137, 0.25}) {
    const NozzleState nozzle = feed.at(t);
    std::set<GlobalIndex> ids;
    for (const Feed::Point& point : feed.points()) {
      const GlobalIndex first = feed.n_layers(feed.released(t), point) + 1, last = feed.n_layers(feed.born(t), point);
      EXPECT_EQ(last - first + 1, 6) << "three cells, two layers each";
      EXPECT_LE(feed.distance(nozzle, first, point), 0.0);
      EXPECT_GT(feed.distance(nozzle, first, point), -feed.layer_height());
      EXPECT_GT(feed.distance(nozzle, last, point), -feed.length());
      EXPECT_LE(feed.distance(nozzle, last + 1, point), -feed.length());
      for (GlobalIndex k = first; k <= last; ++k) {
        const GlobalIndex id = feed.id_of(k, point);
        EXPECT_TRUE(feed.owns(id) && ids.insert(id).second);
        EXPECT_EQ(feed.layer_of(id), k);
        EXPECT_EQ(&feed.point_of(id), &point);
      }
    }
  }
}

TEST(FeedWithAProfile, MovesItsColumnsAsItsVelocitySays) {
  Inflow inflow = jet();
  inflow.direction = Vec3(0.2, 0.1, -1.0);
  const Feed feed(grid(), inflow, 0, 10.0);
  const double t = 0.1, dt = 1e-4;
  const NozzleState before = feed.at(t), after = feed.at(t + dt);
  for (const Feed::Point& point : feed.points()) {
    const Vec3 x = feed.position(before, 9, point), v = feed.velocity(before, x, point.share);
    EXPECT_NEAR(((feed.position(after, 9, point) - x) / dt - v).norm(), 0.0, 1e-10);
    EXPECT_LE(v.norm(), feed.speed_bound(t, t + dt) * (1.0 + 1e-12));
    const double share = 2.0 * (1.0 - point.offset.squaredNorm() / (0.03 * 0.03));
    EXPECT_NEAR(point.share, share, 1e-12);
    EXPECT_NEAR(feed.share_at(before, x), share, 1e-12) << "of a nozzle that is not along an axis";
    const Mat3 shear = feed.shear(before, point);
    EXPECT_NEAR(shear.trace(), 0.0, 1e-12);
    const Vec3 small = 1e-6 * Vec3(0.3, -0.5, 0.2);
    const double change = feed.share_at(before, x + small) - feed.share_at(before, x);
    EXPECT_NEAR((shear * small - change * before.speed * before.axis).norm(), 0.0, 1e-8);
  }
  EXPECT_NEAR(feed.speed_bound(0.0, 1.0), 1.0, 1e-12) << "twice the mean";
}

TEST(FeedWithAProfile, SumsUpToItsFlowOnNodes) {
  const double dx = 0.01;
  const auto sum_of = [&](const Inflow& inflow) {
    const Feed feed(grid(), inflow, 0, 10.0);
    double sum = 0.0;
    for (int i = 0; i <= 20; ++i)
      for (int j = 0; j <= 20; ++j) sum += feed.share_at(feed.at(0.0), Vec3(i * dx, j * dx, 0.11));
    return sum * dx * dx;
  };
  for (const double radius : {0.0201, 0.03, 0.047}) EXPECT_NEAR(sum_of(jet(radius)) / area(DiscSection{radius}), 1.0, 1e-12);
  Inflow slot = jet();
  slot.section = RectangleSection{0.06, 0.1};
  EXPECT_NEAR(sum_of(slot) / 0.006, 1.0, 1e-12);
}

}  // namespace
}  // namespace bulkley::feed_profile_test
