#include "geometry/rigid_motion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace bulkley::rigid_motion_test {
namespace {

constexpr double pi = std::numbers::pi;

RigidMotion tumbling() {
  RigidMotion motion;
  motion.center = Vec3(0.3, -0.2, 0.5);
  motion.key_frames = {{0.5, Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0)},
                       {1.0, Vec3(0.1, 0.3, 0.0), Vec3(0.0, 90.0, 20.0)},
                       {1.2, Vec3(0.4, 0.2, 0.0), Vec3(-30.0, 500.0, 20.0)},
                       {2.0, Vec3(0.5, 0.2, -1.0), Vec3(0.0, 720.0, 0.0)}};
  return motion;
}

TEST(RigidMotion, RestsUnlessToldOtherwise) {
  const RigidMotion rest;
  EXPECT_FALSE(rest.moves());
  EXPECT_EQ(rest.pose(3.0).to_shape(Vec3(1.0, 2.0, 3.0)), Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(rest.velocity_at(3.0).at(Vec3(1.0, 2.0, 3.0)), Vec3(Vec3::Zero()));
  EXPECT_EQ(rest.speed_bound(0.0, 1.0, 10.0), 0.0);
  RigidMotion still;
  still.key_frames = {{0.0, Vec3::Zero(), Vec3::Zero()}, {1.0, Vec3::Zero(), Vec3::Zero()}};
  EXPECT_FALSE(still.moves());
  RigidMotion moved;
  moved.key_frames = {{0.0, Vec3::UnitX(), Vec3::Zero()}, {1.0, Vec3::UnitX(), Vec3::Zero()}};
  EXPECT_TRUE(moved.moves()) << "it stands elsewhere";
}

TEST(RigidMotion, SteadyVelocitiesTurnAboutTheCentreThatMoves) {
  RigidMotion motion;
  motion.center = Vec3(1.0, 0.0, 0.0);
  motion.velocity = Vec3(0.0, 2.0, 0.0);
  motion.angular_velocity = Vec3(0.0, 0.0, pi);
  // After half a second: a quarter turn about (1, 1, 0).
  const Pose pose = motion.pose(0.5);
  EXPECT_LE((pose.to_world(Vec3(2.0, 0.0, 0.0)) - Vec3(1.0, 2.0, 0.0)).norm(), 1e-15);
  EXPECT_LE((pose.to_shape(Vec3(1.0, 2.0, 0.0)) - Vec3(2.0, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_LE((motion.velocity_at(0.5).at(Vec3(1.0, 2.0, 0.0)) - Vec3(-pi, 2.0, 0.0)).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(motion.speed_bound(0.0, 1.0, 3.0), 2.0 + 3.0 * pi);
}

TEST(RigidMotion, GoesThroughItsKeyFramesAndRestsOutside) {
  const RigidMotion motion = tumbling();
  for (const KeyFrame& key : motion.key_frames) {
    const Pose pose = motion.pose(key.time);
    const Vec3 turn = pi / 180.0 * key.rotation_degrees;
    const Mat3 rotation =
        turn.norm() > 0.0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() : Mat3(Mat3::Identity());
    EXPECT_LE((pose.rotation - rotation).norm(), 1e-13) << key.time;
    EXPECT_LE((pose.to_world(motion.center) - motion.center - key.translation).norm(), 1e-14) << key.time;
  }
  for (const double outside : {0.0, 0.5, 2.0, 7.0})
    EXPECT_EQ(motion.velocity_at(outside).at(Vec3(1.0, 1.0, 1.0)), Vec3(Vec3::Zero())) << outside;
  EXPECT_EQ(motion.pose(0.0).translation, motion.pose(0.5).translation);
  EXPECT_EQ(motion.pose(9.0).translation, motion.pose(2.0).translation);
}

TEST(RigidMotion, VelocityIsTheRateOfThePose) {
  const RigidMotion motion = tumbling();
  const Vec3 in_shape(0.7, 0.1, 0.4);
  const double h = 1e-6;
  for (double t = 0.45; t < 2.1; t += 0.0371) {
    const Vec3 before = motion.pose(t - h).to_world(in_shape), after = motion.pose(t + h).to_world(in_shape);
    const Vec3 rate = (after - before) / (2.0 * h);
    const Vec3 velocity = motion.velocity_at(t).at(motion.pose(t).to_world(in_shape));
    EXPECT_LE((velocity - rate).norm(), 1e-4 * (1.0 + rate.norm())) << t;
    const double reach = (in_shape - motion.center).norm();
    EXPECT_LE(velocity.norm(), motion.speed_bound(t, t, reach) * (1.0 + 1e-12)) << t;
  }
}

TEST(RigidMotion, SpeedBoundIsThatOfTheSegmentsInQuestion) {
  RigidMotion motion;
  motion.key_frames = {
      {0.0, Vec3::Zero(), Vec3::Zero()}, {1.0, Vec3::UnitX(), Vec3::Zero()}, {2.0, Vec3::UnitX(), Vec3::Zero()}};
  EXPECT_DOUBLE_EQ(motion.speed_bound(0.1, 0.2, 5.0), 1.5) << "a cubic from rest to rest: one and a half times the mean";
  EXPECT_EQ(motion.speed_bound(1.5, 1.6, 5.0), 0.0);
  EXPECT_EQ(motion.speed_bound(2.5, 3.0, 5.0), 0.0);
}

TEST(RigidMotion, NeverOvershoots) {
  RigidMotion motion;
  motion.key_frames = {{0.0, Vec3(0.0, 0.0, 0.0), Vec3::Zero()},
                       {1.0, Vec3(0.1, 1.0, 0.0), Vec3::Zero()},
                       {1.1, Vec3(2.0, 0.9, 0.0), Vec3::Zero()},
                       {3.0, Vec3(2.1, 0.9, 0.0), Vec3::Zero()}};
  Vec3 last = Vec3::Zero();
  for (double t = 0.0; t < 3.0; t += 1e-3) {
    const Vec3 here = motion.pose(t).translation;
    EXPECT_GE(here[0], last[0] - 1e-15) << t;
    EXPECT_LE(here[1], 1.0 + 1e-15) << t;
    if (t >= 1.0) {
      EXPECT_GE(here[1], 0.9 - 1e-15) << t;
    }
    last = here;
  }
}

TEST(RigidMotion, MovedShapesKeepTheirDistances) {
  const Shape box{Box{Vec3(0.0, 0.0, 0.0), Vec3(0.2, 0.3, 0.4)}};
  const Pose pose = tumbling().pose(1.17);
  for (const Vec3& x : {Vec3(0.1, 0.1, 0.1), Vec3(0.5, -0.3, 0.2), Vec3(-1.0, 2.0, 0.3)}) {
    const Vec3 moved = pose.to_world(x);
    EXPECT_NEAR(signed_distance(box, pose, moved), signed_distance(box, x), 1e-14);
    EXPECT_LE((outward_normal(box, pose, moved) - pose.rotation * outward_normal(box, x)).norm(), 1e-12);
  }
  const Bounds b = bounds(box, pose);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 x = pose.to_world(Vec3(corner & 1 ? 0.2 : 0.0, corner & 2 ? 0.3 : 0.0, corner & 4 ? 0.4 : 0.0));
    EXPECT_TRUE(((x - b.lower).array() >= -1e-14).all() && ((b.upper - x).array() >= -1e-14).all());
  }
}

}  // namespace
}  // namespace bulkley::rigid_motion_test
