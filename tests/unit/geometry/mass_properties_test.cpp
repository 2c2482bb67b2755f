#include "geometry/mass_properties.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>
#include <numbers>

#include "geometry/surface.hpp"

namespace bulkley::mass_properties_test {
namespace {

constexpr double pi = std::numbers::pi;

MassProperties of(const Shape& shape) { return mass_properties(shape).value(); }

TEST(MassProperties, BoxByTextbook) {
  const MassProperties box = of({Box{Vec3(1.0, 2.0, 3.0), Vec3(2.0, 4.0, 6.0)}});
  EXPECT_DOUBLE_EQ(box.volume, 6.0);
  EXPECT_TRUE(box.center.isApprox(Vec3(1.5, 3.0, 4.5)));
  EXPECT_TRUE(box.inertia.isApprox(Mat3(Vec3(6.5, 5.0, 2.5).asDiagonal()), 1e-14));
}

TEST(MassProperties, RoundBodiesByTextbook) {
  EXPECT_NEAR(of({Sphere{Vec3::Zero(), 2.0}}).inertia(1, 1), 0.4 * 4.0 * (4.0 / 3.0 * pi * 8.0), 1e-12);
  const MassProperties cylinder = of({Cylinder{Vec3(0.0, 0.0, 1.0), Vec3(0.0, 0.0, 4.0), 0.5}});
  EXPECT_NEAR(cylinder.inertia(2, 2), cylinder.volume * 0.125, 1e-13);
  EXPECT_NEAR(cylinder.inertia(0, 0), cylinder.volume * (0.25 * 0.25 + 9.0 / 12.0), 1e-13);
}

// The triangles of a surface know nothing of formulas; a capsule's 48 segments lie within it.
TEST(MassProperties, FormulasAgreeWithTheirSurfaces) {
  const Vec3 far(5.0, -3.0, 2.0);
  for (const Shape& shape : {Shape{Capsule{far, far + Vec3(0.3, 0.4, 0.0), 0.25}},
                             Shape{Cylinder{far, far + Vec3::Ones(), 0.4}}, Shape{Ellipsoid{far, Vec3(0.1, 0.2, 0.3)}}}) {
    const MassProperties exact = of(shape), mesh = mass_properties(surface_of(shape, bounds(shape)));
    EXPECT_NEAR(mesh.volume / exact.volume, 1.0, 0.01);
    EXPECT_TRUE(mesh.center.isApprox(exact.center, 1e-6));
    EXPECT_LT((mesh.inertia / mesh.volume - exact.inertia / exact.volume).norm(),
              0.01 * exact.inertia.norm() / exact.volume);
  }
}

TEST(MassProperties, DivergenceTheoremIsExactForABox) {
  const Shape box{Box{Vec3(101.0, 2.0, 3.0), Vec3(102.0, 4.0, 6.0)}};
  const MassProperties exact = of(box), mesh = mass_properties(surface_of(box, bounds(box)));
  EXPECT_NEAR(mesh.volume, exact.volume, 1e-13);
  EXPECT_TRUE(mesh.center.isApprox(exact.center, 1e-14));
  EXPECT_TRUE(mesh.inertia.isApprox(exact.inertia, 1e-13));
}

TEST(MassProperties, PlacedBodyTurnsItsAxes) {
  Placed placed;
  placed.part = std::make_shared<const Shape>(Shape{Box{Vec3(0.0, 0.0, 0.0), Vec3(1.0, 2.0, 3.0)}});
  placed.angle = pi / 2.0;
  placed.translation = Vec3(0.0, 0.0, 1.0);
  const MassProperties turned = of({placed});
  EXPECT_TRUE(turned.center.isApprox(Vec3(-1.0, 0.5, 2.5), 1e-14));
  EXPECT_TRUE(turned.inertia.isApprox(Mat3(Vec3(5.0, 6.5, 2.5).asDiagonal()), 1e-13));
}

TEST(MassProperties, UnknownForWhatIsEndlessOrJoined) {
  EXPECT_FALSE(mass_properties(Shape{Plane{Vec3::Zero(), Vec3::UnitZ()}}));
  EXPECT_FALSE(mass_properties(Shape{Union{{Shape{Sphere{Vec3::Zero(), 1.0}}}}}));
}

TEST(MassProperties, PrincipalFrameIsARotation) {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  const Mat3 inertia = turn * Vec3(3.0, 1.0, 2.0).asDiagonal() * turn.transpose();
  const PrincipalFrame frame = principal_frame(inertia);
  EXPECT_NEAR(frame.axes.determinant(), 1.0, 1e-14);
  EXPECT_TRUE(frame.moments.isApprox(Vec3(1.0, 2.0, 3.0), 1e-14));
  EXPECT_TRUE((frame.axes * frame.moments.asDiagonal() * frame.axes.transpose()).isApprox(inertia, 1e-14));
}

TEST(MassProperties, MomentsObeyTheTriangleInequality) {
  EXPECT_TRUE(are_moments(Vec3(1.0, 2.0, 3.0)));
  EXPECT_FALSE(are_moments(Vec3(1.0, 2.0, 3.1)));
  EXPECT_FALSE(are_moments(Vec3(0.0, 2.0, 2.0)));
}

}  // namespace
}  // namespace bulkley::mass_properties_test
