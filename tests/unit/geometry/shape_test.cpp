#include "geometry/shape.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "bulkley/base/error.hpp"

namespace bulkley::shape_test {
namespace {

constexpr double pi = 3.14159265358979323846;

const Shape box{Box{{-0.1, 0.2, -0.3}, {0.5, 0.6, 0.4}}};
const Shape sphere{Sphere{{0.1, -0.2, 0.3}, 0.4}};
const Shape cylinder{Cylinder{{-0.2, -0.1, 0.0}, {0.3, 0.4, 0.2}, 0.25}};
const Shape capsule{Capsule{{-0.2, -0.1, 0.0}, {0.3, 0.4, 0.2}, 0.25}};
const Shape ellipsoid{Ellipsoid{{0.1, -0.1, 0.2}, {0.7, 0.3, 0.15}}};
const Shape plane{Plane{{0.1, 0.0, 0.0}, {1.0, 2.0, -2.0}}};
const Shape tube{Difference{
    {{Cylinder{{0.1, -0.2, -0.5}, {0.1, -0.2, 0.6}, 0.5}}, {Cylinder{{0.1, -0.2, -0.9}, {0.1, -0.2, 0.9}, 0.3}}}}};
const Shape both{Union{{sphere, box}}};
const Shape bore{Complement{{{cylinder}}}};
Shape placed(const Shape& part, double angle) {
  return {
      Placed{std::make_shared<const Shape>(part), Vec3(1.0, -1.0, 0.5), angle, Vec3(0.1, 0.2, 0.3), Vec3(0.3, -0.1, 0.2)}};
}

std::vector<Vec3> random_points(int count) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Vec3> points;
  for (int n = 0; n < count; ++n) points.push_back(Vec3{uniform(generator), uniform(generator), uniform(generator)});
  return points;
}

/// Volume by counting the cells of an n^3 grid over [-1, 1]^3, those cut by the surface in proportion to their depth.
double volume(const Shape& shape, int n) {
  const double h = 2.0 / n;
  double inside = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        inside += std::clamp(0.5 - signed_distance(shape, h * Vec3(i + 0.5, j + 0.5, k + 0.5) - Vec3::Ones()) / h, 0.0, 1.0);
  return inside * h * h * h;
}

TEST(Shape, DistancesAtKnownPlaces) {
  EXPECT_NEAR(signed_distance(sphere, {0.1, -0.2, 0.3}), -0.4, 1e-15);
  EXPECT_NEAR(signed_distance(sphere, {0.1, -0.2, 1.3}), 0.6, 1e-15);
  EXPECT_NEAR(signed_distance(box, {0.2, 0.4, 0.0}), -0.2, 1e-15);  // nearest faces are those of y
  EXPECT_NEAR(signed_distance(box, {0.7, 0.4, 0.0}), 0.2, 1e-15);   // next to a face
  EXPECT_NEAR(signed_distance(box, {0.8, 1.0, 0.0}), 0.5, 1e-15);   // next to an edge: 3, 4, 5
  EXPECT_NEAR(signed_distance(plane, {1.1, 0.0, 0.0}), 1.0 / 3.0, 1e-15);
  EXPECT_NEAR(signed_distance(plane, {0.1, 0.0, 3.0}), -2.0, 1e-15);

  const Shape upright{Cylinder{{0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}, 0.5}};
  EXPECT_NEAR(signed_distance(upright, {0.3, 0.0, 0.0}), -0.2, 1e-15);
  EXPECT_NEAR(signed_distance(upright, {0.1, 0.0, 0.9}), -0.1, 1e-15);
  EXPECT_NEAR(signed_distance(upright, {0.1, 0.0, 1.2}), 0.2, 1e-15);
  EXPECT_NEAR(signed_distance(upright, {0.0, 0.8, 1.4}), 0.5, 1e-15);
  const Shape pill{Capsule{{0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}, 0.5}};
  EXPECT_NEAR(signed_distance(pill, {0.3, 0.0, 0.5}), -0.2, 1e-15);
  EXPECT_NEAR(signed_distance(pill, {0.3, 0.0, 1.4}), 0.0, 1e-15);
  EXPECT_NEAR(signed_distance(ellipsoid, {0.1, -0.1, 0.2}), -0.15, 1e-12);  // the centre: as deep as the shortest axis
  EXPECT_NEAR(signed_distance(ellipsoid, {1.0, -0.1, 0.2}), 0.2, 1e-14);
  EXPECT_NEAR(signed_distance(ellipsoid, {0.1, -0.5, 0.2}), 0.1, 1e-14);
  // From inside the focal conic the nearest point is off the axis: of (0.3, 0, 0) with half axes 0.7 and 0.15 it has the
  // abscissa 0.3 x 0.49 / (0.49 - 0.0225).
  const double abscissa = 0.3 * 0.49 / 0.4675, height = 0.15 * std::sqrt(1.0 - abscissa * abscissa / 0.49);
  EXPECT_NEAR(signed_distance(ellipsoid, {0.4, -0.1, 0.2}), -std::hypot(abscissa - 0.3, height), 1e-12);
  const Shape round{Ellipsoid{{0.1, -0.2, 0.3}, {0.4, 0.4, 0.4}}};
  for (const Vec3& x : random_points(100)) EXPECT_NEAR(signed_distance(round, x), signed_distance(sphere, x), 1e-14);
  EXPECT_NEAR(signed_distance(tube, {0.1, -0.2, 0.0}), 0.3, 1e-15);    // on the axis, in the hole
  EXPECT_NEAR(signed_distance(tube, {0.1, 0.15, 0.0}), -0.05, 1e-15);  // nearer to the inner wall
  EXPECT_NEAR(signed_distance(tube, {0.1, 0.6, 0.0}), 0.3, 1e-15);
  EXPECT_NEAR(outward_normal(tube, {0.1, 0.15, 0.0}).y(), -1.0, 1e-15);  // into the hole
  EXPECT_NEAR(signed_distance(both, {0.1, -0.2, 0.3}), -0.4, 1e-15);
  EXPECT_NEAR(signed_distance(both, {0.7, 0.4, 0.0}), 0.2, 1e-15);
}

TEST(Shape, VolumesAreExact) {
  const double length = std::sqrt(0.5 * 0.5 + 0.5 * 0.5 + 0.2 * 0.2);
  const double ball = 4.0 / 3.0 * pi;
  const int n = 160;
  EXPECT_NEAR(volume(box, n), 0.6 * 0.4 * 0.7, 1e-3 * 0.168);
  EXPECT_NEAR(volume(sphere, n), ball * 0.064, 1e-3 * ball * 0.064);
  EXPECT_NEAR(volume(cylinder, n), pi * 0.0625 * length, 1e-3 * pi * 0.0625 * length);
  EXPECT_NEAR(volume(capsule, n), pi * 0.0625 * length + ball * 0.015625, 1e-3 * (pi * 0.0625 * length + ball * 0.015625));
  EXPECT_NEAR(volume(ellipsoid, n), ball * 0.7 * 0.3 * 0.15, 1e-3 * ball * 0.7 * 0.3 * 0.15);
  EXPECT_NEAR(volume(tube, n), pi * 0.16 * 1.1, 1e-3 * pi * 0.16 * 1.1);
  EXPECT_NEAR(volume(placed(Shape{Box{{-0.2, -0.3, -0.1}, {0.3, 0.2, 0.4}}}, 0.7), n), 0.125, 1e-3 * 0.125);
}

TEST(Shape, DistancesGrowByOneAlongTheNormal) {
  const Shape shapes[] = {box, sphere, cylinder, capsule, ellipsoid, plane, both, placed(box, 0.8), placed(cylinder, 2.0)};
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(shape.kind.index());
    for (const Vec3& x : random_points(300)) {
      const Vec3 n = outward_normal(shape, x);
      EXPECT_NEAR(n.norm(), 1.0, 1e-14);
      const double d = signed_distance(shape, x);
      if (d < 1e-6) continue;                            // inside, the nearest surface may change on the way
      if (!std::holds_alternative<Union>(shape.kind)) {  // outside a union another part may come nearer
        EXPECT_NEAR(signed_distance(shape, x + 0.1 * n), d + 0.1, 1e-13);
      }
      EXPECT_NEAR(signed_distance(shape, x - d * n), 0.0, 1e-13);  // the foot of the perpendicular
    }
  }
}

TEST(Shape, AComplementIsTheOtherSideOfItsParts) {
  const Shape around{Complement{{{sphere, box}}}};
  EXPECT_NO_THROW(check_shape(around, "collider 'a'"));
  for (const Vec3& x : random_points(300)) {
    EXPECT_EQ(signed_distance(around, x), -signed_distance(both, x));
    EXPECT_EQ(outward_normal(around, x), Vec3(-outward_normal(both, x)));
  }
  EXPECT_GT(signed_distance(bore, 0.5 * (bounds(cylinder).lower + bounds(cylinder).upper)), 0.0);
  EXPECT_EQ(bounds(bore).lower.x(), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(bounds(bore).upper.z(), std::numeric_limits<double>::infinity());
}

TEST(Shape, NormalsAreTheGradientInsideToo) {
  const Shape shapes[] = {
      box, sphere, cylinder, capsule, ellipsoid, plane, both, tube, bore, placed(box, 0.8), placed(capsule, -1.0)};
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(shape.kind.index());
    const double h = 1e-6;
    int close = 0, tested = 0;
    for (const Vec3& x : random_points(20000)) {
      if (signed_distance(shape, x) > 0.0) continue;
      Vec3 gradient;
      for (int a = 0; a < 3; ++a)
        gradient[a] =
            (signed_distance(shape, x + h * Vec3::Unit(a)) - signed_distance(shape, x - h * Vec3::Unit(a))) / (2 * h);
      ++tested;
      close += (gradient - outward_normal(shape, x)).norm() < 1e-6 ? 1 : 0;
    }
    EXPECT_GT(tested, 300);
    EXPECT_GE(close, tested - 2);  // a difference may straddle an edge of the distance
  }
}

TEST(Shape, SphereNormalIsRadial) {
  for (const Vec3& x : random_points(200))
    EXPECT_LE((outward_normal(sphere, x) - (x - Vec3(0.1, -0.2, 0.3)).normalized()).norm(), 1e-12);
}

TEST(Shape, NormalsExistWhereTheyAreNotUnique) {
  EXPECT_NEAR(outward_normal(sphere, {0.1, -0.2, 0.3}).norm(), 1.0, 1e-15);
  EXPECT_NEAR(outward_normal(cylinder, {0.05, 0.15, 0.1}).norm(), 1.0, 1e-14);
  EXPECT_NEAR(outward_normal(capsule, {0.05, 0.15, 0.1}).norm(), 1.0, 1e-14);
  EXPECT_NEAR(outward_normal(box, {0.2, 0.4, 0.05}).norm(), 1.0, 1e-15);
  EXPECT_EQ(outward_normal(box, {0.5, 0.4, 0.05}), Vec3(Vec3::UnitX()));  // on a face
  EXPECT_EQ(outward_normal(box, {-0.1, 0.4, 0.05}), Vec3(-Vec3::UnitX()));
}

TEST(Shape, PlacedTurnsThenMoves) {
  const Shape bar{Box{{0.0, -0.1, -0.1}, {1.0, 0.1, 0.1}}};
  const Shape turned{
      Placed{std::make_shared<const Shape>(bar), Vec3(0.0, 0.0, 3.0), pi / 2, Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.5)}};
  // The bar now runs from (1, -1, 0.5) to (1, 0, 0.5).
  EXPECT_NEAR(signed_distance(turned, {1.0, -0.5, 0.5}), -0.1, 1e-15);
  EXPECT_NEAR(signed_distance(turned, {1.0, 0.3, 0.5}), 0.3, 1e-15);
  EXPECT_NEAR(signed_distance(turned, {1.0, -1.2, 0.5}), 0.2, 1e-15);
  EXPECT_LE((outward_normal(turned, {1.0, 0.3, 0.5}) - Vec3::UnitY()).norm(), 1e-15);
}

TEST(Shape, BoundsHoldTheShapeAndTouchIt) {
  const Shape shapes[] = {box, sphere, cylinder, capsule, ellipsoid, both, tube, placed(cylinder, 0.4), placed(both, -2.0)};
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(shape.kind.index());
    const Bounds b = bounds(shape);
    const Vec3 center = 0.5 * (b.lower + b.upper), reach = 0.75 * (b.upper - b.lower);  // also beyond the bounds
    Vec3 lowest = Vec3::Constant(10.0), highest = Vec3::Constant(-10.0);
    for (const Vec3& point : random_points(50000)) {
      const Vec3 x = center + reach.cwiseProduct(point);
      if (signed_distance(shape, x) > 0.0) continue;
      lowest = lowest.cwiseMin(x);
      highest = highest.cwiseMax(x);
    }
    const bool tight = !std::holds_alternative<Placed>(shape.kind);
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(b.lower[a], lowest[a]);
      EXPECT_GE(b.upper[a], highest[a]);
      if (!tight) continue;
      EXPECT_NEAR(b.lower[a], lowest[a], 0.06);
      EXPECT_NEAR(b.upper[a], highest[a], 0.06);
    }
  }
  // A disc of radius 1/4 with this normal reaches R sqrt(1 - n_z^2) along z; n_z^2 = 0.04 / 0.54.
  EXPECT_NEAR(bounds(cylinder).upper.z(), 0.2 + 0.25 * std::sqrt(0.5 / 0.54), 1e-15);
  EXPECT_NEAR(bounds(capsule).upper.z(), 0.45, 1e-15);
  EXPECT_EQ(bounds(plane).upper.x(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(bounds(placed(plane, 1.0)).lower.y(), -std::numeric_limits<double>::infinity());
}

TEST(Shape, DegenerateShapesAreUsageErrors) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Shape bad[] = {{Box{{0, 0, 0}, {1, 0, 1}}},
                       {Box{{0, 0, 0}, {1, 1, nan}}},
                       {Sphere{{0, 0, 0}, 0.0}},
                       {Sphere{{0, nan, 0}, 1.0}},
                       {Cylinder{{0, 0, 1}, {0, 0, 1}, 1.0}},
                       {Cylinder{{0, 0, 0}, {0, 0, 1}, -1.0}},
                       {Capsule{{0, 0, 0}, {0, 0, 1}, nan}},
                       {Ellipsoid{{0, 0, 0}, {1, 0, 1}}},
                       {Ellipsoid{{0, 0, 0}, {1, nan, 1}}},
                       {Plane{{0, 0, 0}, {0, 0, 0}}},
                       {Union{}},
                       {Union{{sphere, {Sphere{{0, 0, 0}, -1.0}}}}},
                       {Complement{}},
                       {Complement{{{{Sphere{{0, 0, 0}, -1.0}}}}}},
                       {Difference{{sphere}}},
                       {Difference{{sphere, {Sphere{{0, 0, 0}, -1.0}}}}},
                       {Placed{}},
                       placed({Sphere{{0, 0, 0}, 0.0}}, 0.0),
                       placed(sphere, nan)};
  for (const Shape& shape : bad) EXPECT_THROW(check_shape(shape, "body 'a'"), UsageError) << shape.kind.index();
  const Shape good[] = {
      box, sphere, cylinder, capsule, ellipsoid, plane, both, placed(both, 1.0), {Capsule{{0, 0, 0}, {0, 0, 0}, 1.0}}};
  for (const Shape& shape : good) EXPECT_NO_THROW(check_shape(shape, "body 'a'")) << shape.kind.index();
  try {
    check_shape({Sphere{{0, 0, 0}, -2.0}}, "collider 'rod'");
    FAIL() << "a negative radius was accepted";
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "collider 'rod': a sphere needs a finite centre and a radius > 0");
  }
}

}  // namespace
}  // namespace bulkley::shape_test
