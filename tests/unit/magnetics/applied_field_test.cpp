#include "magnetics/applied_field.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "bulkley/base/error.hpp"
#include "magnetics/elliptic.hpp"
#include "magnetics/magnetisation.hpp"

namespace bulkley::applied_field_test {
namespace {

constexpr double pi = std::numbers::pi;

template <class Kind>
FieldSource source_of(const Kind& kind) {
  FieldSource source;
  source.kind = kind;
  return source;
}

Dipole dipole(const Vec3& centre = Vec3::Zero(), const Vec3& axis = Vec3::UnitZ()) { return {centre, axis, 2.5}; }
BoxMagnet box(const Vec3& centre = Vec3::Zero(), const Vec3& axis = Vec3::UnitZ()) {
  return {centre, axis, Vec3::Zero(), Vec3(0.04, 0.03, 0.01), 1e6 * vacuum_permeability};
}
CylinderMagnet cylinder(const Vec3& centre = Vec3::Zero(), const Vec3& axis = Vec3::UnitZ()) {
  return {centre, axis, 0.02, 0.01, 1e6 * vacuum_permeability};
}
Coil coil(const Vec3& centre = Vec3::Zero(), const Vec3& axis = Vec3::UnitZ()) { return {centre, axis, 0.02, 1.0}; }

Vec3 value(const FieldSource& source, const Vec3& x, double t = 0.0) { return AppliedField({source}).at(x, t); }

void expect_near(const Vec3& value, const Vec3& expected, double relative) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(value[axis], expected[axis], relative * expected.norm()) << axis;
}

TEST(EllipticIntegral, HasItsKnownValues) {
  EXPECT_NEAR(complete_elliptic(1.0, 1.0, 1.0, 1.0), pi / 2.0, 1e-15);
  EXPECT_NEAR(complete_elliptic(0.5, 1.0, 1.0, 1.0), std::comp_ellint_1(std::sqrt(0.75)), 1e-14);
  EXPECT_NEAR(complete_elliptic(0.5, 1.0, 1.0, 0.25), std::comp_ellint_2(std::sqrt(0.75)), 1e-14);
  EXPECT_NEAR(complete_elliptic(0.5, 0.3, 1.0, 1.0), std::comp_ellint_3(std::sqrt(0.75), 0.7), 1e-14);
  EXPECT_TRUE(std::isnan(complete_elliptic(0.0, 1.0, 1.0, 1.0)));
  EXPECT_TRUE(std::isnan(complete_elliptic(0.5, 0.0, 1.0, 1.0)));
}

TEST(AppliedField, HasTheReferenceValues) {
  const Vec3 x(0.013, 0.0, 0.012);
  expect_near(value(source_of(coil()), Vec3(0.013, 0.0, 0.01)), Vec3(9.1535571747, 0.0, 15.9764449402), 1e-10);
  expect_near(value(source_of(cylinder()), x), Vec3(78939.913986, 0.0, 137925.876338), 1e-10);
  expect_near(value(source_of(box()), Vec3(0.013, 0.007, 0.012)), Vec3(61270.92705, 46062.57432, 134569.43614), 1e-10);
}

TEST(AppliedField, OfMagnetsFarAwayIsThatOfDipoles) {
  const Vec3 x(3.0, -2.0, 4.0);
  const double M = 1e6;
  for (const auto& [magnet, moment] : {std::pair{source_of(box()), M * 0.04 * 0.03 * 0.01},
                                       {source_of(cylinder()), M * pi * 4e-4 * 0.01},
                                       {source_of(coil()), pi * 4e-4}}) {
    Dipole far = dipole();
    far.moment = moment;
    expect_near(value(magnet, x), value(source_of(far), x), 5e-5);
  }
}

TEST(AppliedField, OnAxesIsThatOfTheClosedForms) {
  const double a = 0.02, b = 0.005;
  for (const double z : {0.006, 0.03, -0.05, 1.0}) {
    const auto end = [&](double distance) { return distance / std::hypot(distance, a); };
    EXPECT_NEAR(value(source_of(cylinder()), Vec3(0.0, 0.0, z))[2], 0.5e6 * (end(z + b) - end(z - b)), 1e-6);
    EXPECT_NEAR(value(source_of(coil()), Vec3(0.0, 0.0, z))[2], a * a / (2.0 * std::pow(a * a + z * z, 1.5)), 1e-12);
    // Near the axis the radial part is that of a field without divergence: -rho/2 dH_z/dz.
    const double rho = 1e-9;
    const double slope = -1.5 * a * a * z / std::pow(a * a + z * z, 2.5);
    EXPECT_NEAR(value(source_of(coil()), Vec3(rho, 0.0, z))[0] / (-0.5 * rho * slope), 1.0, 1e-5) << z;
  }
}

TEST(AppliedField, HasNeitherDivergenceNorCurl) {
  const double step = 1e-5;
  const std::vector<FieldSource> sources = {source_of(dipole()), source_of(box()), source_of(cylinder()), source_of(coil())};
  const std::vector<Vec3> places = {Vec3(0.013, 0.007, 0.012), Vec3(-0.03, 0.021, 0.004), Vec3(0.001, 0.0, -0.03),
                                    Vec3(0.0, 0.05, 0.0), Vec3(0.02, 0.0, 0.011)};
  for (const FieldSource& source : sources) {
    const AppliedField field({source});
    for (const Vec3& x : places) {
      Mat3 gradient;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 d = step * Vec3::Unit(axis);
        // Differences of the fourth order.
        gradient.col(axis) = (8.0 * (field.at(x + d, 0.0) - field.at(x - d, 0.0)) -
                              (field.at(x + 2.0 * d, 0.0) - field.at(x - 2.0 * d, 0.0))) /
                             (12.0 * step);
      }
      const double size = gradient.norm();
      EXPECT_NEAR(gradient.trace(), 0.0, 1e-8 * size) << source.kind.index() << " at " << x.transpose();
      EXPECT_LT((gradient - gradient.transpose()).norm(), 2e-8 * size) << source.kind.index() << " at " << x.transpose();
    }
  }
}

TEST(AppliedField, OfABoxIsTheSumOverItsPoles) {
  // 400 x 400 point charges on each face, midpoint rule.
  const Vec3 x(0.013, 0.007, 0.012);
  Vec3 sum = Vec3::Zero();
  const int n = 400;
  const double dx = 0.04 / n, dy = 0.03 / n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (const double end : {1.0, -1.0}) {
        const Vec3 r = x - Vec3(-0.02 + (i + 0.5) * dx, -0.015 + (j + 0.5) * dy, end * 0.005);
        sum += end * 1e6 * dx * dy / (4.0 * pi) * r / std::pow(r.norm(), 3);
      }
  expect_near(value(source_of(box()), x), sum, 1e-5);
}

TEST(AppliedField, KeepsItsDigitsBesideEdges) {
  // On the continuation of an edge all logarithms are of zero; from both sides the field must be the same.
  for (const double y : {-0.06, 0.06}) {
    const Vec3 on(0.02, y, 0.005);
    const Vec3 at = value(source_of(box()), on);
    ASSERT_TRUE(at.allFinite());
    expect_near(value(source_of(box()), on + Vec3(1e-11, 0.0, 1e-11)), at, 1e-8);
    expect_near(value(source_of(box()), on - Vec3(1e-11, 0.0, 1e-11)), at, 1e-8);
  }
  const Vec3 above(0.02, 0.0, 0.011);
  const Vec3 at = value(source_of(cylinder()), above);
  expect_near(value(source_of(cylinder()), above + Vec3(1e-9, 0.0, 0.0)), at, 1e-6);
  expect_near(value(source_of(cylinder()), above - Vec3(1e-9, 0.0, 0.0)), at, 1e-6);
}

TEST(AppliedField, TurnsAndMovesWithItsSource) {
  const Vec3 centre(0.1, -0.2, 0.3), axis(1.0, 2.0, -2.0);
  const Mat3 axes = own_axes(axis);
  EXPECT_LT((axes * axes.transpose() - Mat3::Identity()).norm(), 1e-15);
  EXPECT_NEAR(axes.determinant(), 1.0, 1e-15);
  expect_near(axes.col(2), axis / 3.0, 1e-15);
  EXPECT_EQ(own_axes(Vec3(0.0, 0.0, 5.0)), Mat3(Mat3::Identity()));
  const Vec3 x(0.013, 0.007, 0.012);
  expect_near(value(source_of(box(centre, axis)), centre + axes * x), axes * value(source_of(box()), x), 1e-12);
  expect_near(value(source_of(coil(centre, axis)), centre + axes * x), axes * value(source_of(coil()), x), 1e-12);

  FieldSource carried = source_of(box(centre, axis));
  carried.motion.velocity = Vec3(0.5, 0.0, -1.0);
  carried.motion.angular_velocity = Vec3(0.0, 3.0, 0.0);
  const Pose pose = carried.motion.pose(0.4);
  const Vec3 there = pose.to_world(centre + axes * x);
  expect_near(value(carried, there, 0.4), pose.rotation * axes * value(source_of(box()), x), 1e-12);
  // A field that is asked for another time and back again has forgotten nothing.
  const AppliedField field({carried});
  const Vec3 first = field.at(there, 0.4);
  field.at(there, 0.7);
  EXPECT_EQ(field.at(there, 0.4), first);
}

TEST(AppliedField, AddsSourcesAndFollowsAmplitudes) {
  FieldSource pulsed = source_of(UniformField{{"2e4*cos(20*t)", "2e4*sin(20*t)", "0"}});
  pulsed.amplitude = "t < 0.5 ? 1 : 0";
  const FieldSource gradient = source_of(FieldFormula{{"-5*x", "-5*y", "10*z"}});
  const AppliedField field({pulsed, gradient});
  const Vec3 x(1.0, 2.0, 3.0);
  expect_near(field.at(x, 0.1), Vec3(2e4 * std::cos(2.0) - 5.0, 2e4 * std::sin(2.0) - 10.0, 30.0), 1e-14);
  expect_near(field.at(x, 0.6), Vec3(-5.0, -10.0, 30.0), 1e-14);
}

TEST(AppliedField, KnowsWhetherItVaries) {
  FieldSource source = source_of(UniformField{{"1", "0", "0"}});
  EXPECT_FALSE(AppliedField({source}).varies());
  source.amplitude = "2*t";
  EXPECT_TRUE(AppliedField({source}).varies());
  source.amplitude = "sqrt(2)";
  EXPECT_FALSE(AppliedField({source}).varies());
  EXPECT_TRUE(AppliedField({source_of(UniformField{{"1", "0", "3*t"}})}).varies());
  EXPECT_TRUE(AppliedField({source_of(FieldFormula{{"x", "y*t", "0"}})}).varies());
  FieldSource moved = source_of(coil());
  EXPECT_FALSE(AppliedField({moved}).varies());
  moved.motion.velocity = Vec3(1.0, 0.0, 0.0);
  EXPECT_TRUE(AppliedField({moved}).varies());
  EXPECT_FALSE(AppliedField({}).varies());
  EXPECT_EQ(AppliedField({}).at(Vec3(1.0, 1.0, 1.0), 0.0), Vec3(Vec3::Zero()));
  source.amplitude = "2*u";
  EXPECT_THROW(AppliedField({source}), UsageError);
}

TEST(AppliedField, KnowsWhenSourcesChange) {
  FieldSource pulse = source_of(coil());
  pulse.amplitude = "t < 1 ? 2 : (t < 2 ? 2 - t : 0)";
  const AppliedField field({pulse});
  EXPECT_FALSE(field.changes(0.0, 0.9));
  EXPECT_TRUE(field.changes(0.9, 1.1));
  EXPECT_FALSE(field.changes(2.0, 3.0));
  FieldSource moved = source_of(box());
  moved.motion.key_frames = {{0.0}, {1.0, Vec3(0.0, 0.0, 1.0)}, {2.0, Vec3(0.0, 0.0, 1.0), Vec3(0.0, 0.0, 90.0)}};
  EXPECT_TRUE(AppliedField({moved}).changes(0.2, 0.3));
  EXPECT_TRUE(AppliedField({moved}).changes(1.2, 1.3));
  EXPECT_FALSE(AppliedField({moved}).changes(2.0, 9.0));
  EXPECT_TRUE(AppliedField({source_of(UniformField{{"1", "0", "3*t"}})}).changes(0.0, 0.1));
  EXPECT_FALSE(AppliedField({source_of(UniformField{{"1", "0", "t < 1 ? t : 1"}})}).changes(1.0, 1.5));
  EXPECT_FALSE(AppliedField({source_of(UniformField{{"1", "0", "3"}})}).changes(0.0, 9.0));
  FieldSource formula = source_of(FieldFormula{{"x", "-y", "0*t"}});
  EXPECT_TRUE(AppliedField({formula}).changes(0.0, 0.1));
  formula.amplitude = "0";
  EXPECT_FALSE(AppliedField({formula}).changes(0.0, 0.1));
}

TEST(MagnetBodies, StandWhereTheirPolesAre) {
  FieldSource source;
  BoxMagnet box;
  box.center = Vec3(0.1, 0.2, 0.3);
  box.axis = Vec3(0.0, 2.0, 0.0);
  box.side = Vec3::UnitX();
  box.sizes = Vec3(0.04, 0.06, 0.02);
  source.kind = box;
  const Shape block = *body_of(source);
  EXPECT_NEAR(signed_distance(block, box.center), -0.01, 1e-15);
  EXPECT_NEAR(signed_distance(block, box.center + Vec3(0.0, 0.015, 0.0)), 0.005, 1e-15);
  EXPECT_NEAR(signed_distance(block, box.center + Vec3(0.025, 0.0, 0.0)), 0.005, 1e-15);
  EXPECT_NEAR(signed_distance(block, box.center + Vec3(0.0, 0.0, 0.035)), 0.005, 1e-15);
  CylinderMagnet rod;
  rod.axis = Vec3(0.0, 0.0, 3.0);
  rod.radius = 0.01;
  rod.length = 0.1;
  source.kind = rod;
  EXPECT_NEAR(signed_distance(*body_of(source), Vec3(0.0, 0.0, 0.06)), 0.01, 1e-15);
  EXPECT_NEAR(signed_distance(*body_of(source), Vec3(0.015, 0.0, 0.0)), 0.005, 1e-15);
  source.kind = Coil{};
  EXPECT_FALSE(body_of(source));
}

}  // namespace
}  // namespace bulkley::applied_field_test
