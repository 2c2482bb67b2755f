#include "geometry/thickness.hpp"

#include <gtest/gtest.h>

namespace bulkley::thickness_test {
namespace {

const Bounds room{Vec3(-1.0, -1.0, -1.0), Vec3(1.0, 1.0, 1.0)};

TEST(Thickness, OfSimpleShapesIsTheirDiameterOrShortestSide) {
  const double resolution = 0.011;  // strides are a hundredth of what is enough
  EXPECT_NEAR(thickness({Capsule{{-0.5, 0.1, 0.2}, {0.5, -0.3, 0.1}, 0.05}}, room, 1.0), 0.1, resolution);
  EXPECT_NEAR(thickness({Cylinder{{-0.5, 0.1, 0.2}, {0.5, -0.3, 0.1}, 0.05}}, room, 1.0), 0.1, resolution);
  EXPECT_NEAR(thickness({Sphere{{0.1, 0.2, 0.3}, 0.2}}, room, 1.0), 0.4, resolution);
  EXPECT_NEAR(thickness({Box{{-0.5, -0.4, 0.0}, {0.5, 0.4, 0.03}}}, room, 1.0), 0.03, resolution);
  Placed turned{std::make_shared<const Shape>(Shape{Box{{-0.5, -0.4, 0.0}, {0.5, 0.4, 0.03}}}), Vec3(1.0, 2.0, 3.0), 0.7};
  EXPECT_NEAR(thickness({turned}, room, 1.0), 0.03, resolution);
}

TEST(Thickness, FindsTheWallOfATube) {
  const Shape tube{Difference{
      {Shape{Cylinder{{0.0, 0.0, -0.5}, {0.0, 0.0, 0.5}, 0.4}}, Shape{Cylinder{{0.0, 0.0, -0.6}, {0.0, 0.0, 0.6}, 0.35}}}}};
  EXPECT_NEAR(thickness(tube, room, 0.5), 0.05, 0.006);
}

TEST(Thickness, EndlessObstaclesAreThickAndEdgesDoNotCount) {
  EXPECT_EQ(thickness({Plane{{0.0, 0.0, 0.1}, Vec3(0.1, 0.0, 1.0)}}, room, 0.2), 0.2);
  EXPECT_EQ(thickness({Complement{{{Shape{Sphere{{0.0, 0.0, 0.0}, 0.5}}}}}}, room, 0.2), 0.2);
  EXPECT_EQ(thickness({Box{{-0.5, -0.4, -0.3}, {0.5, 0.4, 0.3}}}, room, 0.2), 0.2);
  EXPECT_EQ(thickness({Sphere{{5.0, 0.0, 0.0}, 0.5}}, room, 0.2), 0.2) << "outside the window";
}

TEST(Thickness, OfWhatIsVeryFlatOrSlender) {
  EXPECT_NEAR(thickness({Box{{-0.5, -0.4, 0.0}, {0.5, 0.4, 1e-12}}}, room, 1.0), 0.0, 0.011);
  EXPECT_NEAR(thickness({Box{{-0.5, 0.0, 0.0}, {0.5, 1e-9, 1e-30}}}, room, 1.0), 0.0, 0.011);
  EXPECT_NEAR(thickness({Box{{-0.5, 0.0, 0.0}, {0.5, 1e-3, 1e-3}}}, room, 0.1), 1e-3, 1e-3);
  const double far = 1e90;
  const Bounds endless{Vec3::Constant(-far), Vec3::Constant(far)};
  EXPECT_LE(thickness({Box{{0.0, 0.0, 0.0}, {far, far, 1e-3}}}, endless, 1.0), 1.0);
}

}  // namespace
}  // namespace bulkley::thickness_test
