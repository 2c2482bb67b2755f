// Obstacles in a scene: their motion, and how thick they must be.

#include <gtest/gtest.h>

#include "support/scene_text.hpp"

namespace bulkley::scene_test::colliders_test {
namespace {

std::string with_rod(const std::string& keys, double radius = 0.06) {
  return small_scene +
         "[[colliders]]\nname = \"rod\"\nshape = { type = \"capsule\", start = [0.1, 0.5, 0.1], end = [0.9, 0.5, 0.1], "
         "radius = " +
         std::to_string(radius) + " }\n" + keys;
}

std::string thickness_faults(const Scene& scene) {
  try {
    check_colliders(scene);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(SceneColliders, MoveSteadilyAboutTheirCentre) {
  const Scene scene = parsed(with_rod("velocity = [0, 0, -1]\nangular_velocity = [0, 2, 0]\n"));
  const RigidMotion& motion = scene.colliders[0].motion;
  EXPECT_EQ(motion.velocity, Vec3(0.0, 0.0, -1.0));
  EXPECT_EQ(motion.angular_velocity, Vec3(0.0, 2.0, 0.0));
  EXPECT_LE((motion.center - Vec3(0.5, 0.5, 0.1)).norm(), 1e-15);
  EXPECT_EQ(parsed(with_rod("center = [0.1, 0.5, 0.1]\n")).colliders[0].motion.center, Vec3(0.1, 0.5, 0.1));
  const Scene again = parse_scene(scene.effective_text, "again.toml", {});
  EXPECT_EQ(again.colliders[0].motion.angular_velocity, motion.angular_velocity);
  EXPECT_EQ(again.colliders[0].motion.center, motion.center);
}

TEST(SceneColliders, FollowKeyFrames) {
  const Scene scene =
      parsed(with_rod("key_frames = [{ time = 0.1 }, { time = 0.3, translation = [0, 0, 0.2], rotation = [0, 0, 720] }]\n"));
  const auto& keys = scene.colliders[0].motion.key_frames;
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[1].translation, Vec3(0.0, 0.0, 0.2));
  EXPECT_EQ(keys[1].rotation_degrees, Vec3(0.0, 0.0, 720.0));
  const Scene again = parse_scene(scene.effective_text, "again.toml", {});
  ASSERT_EQ(again.colliders[0].motion.key_frames.size(), 2u);
  EXPECT_EQ(again.colliders[0].motion.key_frames[1].rotation_degrees, keys[1].rotation_degrees);
}

TEST(SceneFaults, KeyFramesStandAloneAndInOrder) {
  EXPECT_EQ(faults_of(with_rod("key_frames = [{ time = 0.1 }]\n")),
            "s.toml:16:14: 'colliders.0.key_frames' must hold at least two key frames");
  EXPECT_EQ(
      faults_of(with_rod("key_frames = [{ time = 0.1 }, { time = 0.1 }]\n")),
      "s.toml:16:31: 'colliders.0.key_frames.1.time' is 0.1 and must be later than that of the previous key frame, 0.1");
  EXPECT_EQ(faults_of(with_rod("velocity = [1, 0, 0]\nkey_frames = [{ time = 0.1 }, { time = 0.2 }]\n")),
            "s.toml:16:1: 'colliders.0.velocity' is given but applies only with no key_frames");
  EXPECT_EQ(faults_of(small_scene + "[[colliders]]\nname = \"drum\"\nangular_velocity = [0, 0, 1]\nshape = { type = "
                                    "\"complement\", parts = [{ type = \"sphere\", center = [0, 0, 0], radius = 1 }] }\n"),
            "s.toml:13:1: collider 'drum' rotates and its shape has no centre; give it a 'center'");
}

TEST(CheckColliders, RefusesWhatIsThinnerThanTwoCells) {
  EXPECT_EQ(thickness_faults(parsed(with_rod("", 0.05))), "") << "just two cells of 0.05 m";
  EXPECT_EQ(thickness_faults(parsed(with_rod("", 0.02))),
            "s.toml:13:1: collider 'rod' is 0.04 m thick, 0.8 cells: it must be at least 2 cells thick, or material on one "
            "side interacts with material on the other; make it 0.1 m thick or the cells at most 0.02 m");
  EXPECT_EQ(thickness_faults(parsed(with_rod("", 0.02), {"domain.cell_size=0.02"})), "");
  EXPECT_EQ(
      thickness_faults(parsed(small_scene + "[[colliders]]\nname = \"floor\"\nshape = { type = \"plane\", point = [0, 0, "
                                            "0.01], normal = [0, 0, 1] }\n")),
      "");
}

}  // namespace
}  // namespace bulkley::scene_test::colliders_test
