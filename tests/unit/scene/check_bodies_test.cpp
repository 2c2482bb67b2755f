// What the shapes' geometry says about a scene.

#include <gtest/gtest.h>

#include "support/scene_text.hpp"

namespace bulkley::scene_test::check_bodies_test {
namespace {

std::string geometry_faults(const Scene& scene) {
  try {
    check_bodies(scene);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}
std::string geometry_faults(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return geometry_faults(parsed(text, overrides));
}

std::string second_body(const std::string& shape) {
  return "[[bodies]]\nname = \"second\"\nmaterial = \"fluid\"\nshape = " + shape + "\n";
}

TEST(CheckBodies, AcceptsABodyInsideAndUpToTheWalls) {
  EXPECT_EQ(geometry_faults(small_scene), "");
  EXPECT_EQ(geometry_faults(with_shape("{ type = \"box\", lower = [0, 0, 0], upper = [1, 1, 0.5] }")), "");
}

TEST(CheckBodies, RefusesABodyOutside) {
  EXPECT_EQ(geometry_faults(small_scene, {"bodies.0.shape.radius=0.3"}),
            "s.toml:9:1: body 'ball' reaches from (0.2, 0.2, -0.05) to (0.8, 0.8, 0.55), outside the domain from (0, 0, 0) "
            "to (1, 1, "
            "0.5)");
  EXPECT_NE(geometry_faults(small_scene, {"bodies.0.shape.center=[5,5,5]"}), "");
}

TEST(CheckBodies, JudgesRotatedShapesByTheirPoints) {
  // The box that holds the turned bar sticks out of the domain; the bar itself does not, until it is made longer.
  const std::string bar =
      "{ type = \"cylinder\", start = [0.1, 0.5, 0.25], end = [0.9, 0.5, 0.25], radius = 0.06, "
      "rotation = { axis = [0, 0, 1], angle = 45, origin = [0.5, 0.5, 0.25] }, translation = [0, 0, 0.18] }";
  EXPECT_EQ(geometry_faults(with_shape(bar)), "");
  const std::string turned_ball =
      "{ type = \"sphere\", center = [0.2, 0.5, 0.25], radius = 0.195, "
      "rotation = { axis = [0, 0, 1], angle = 45, origin = [0.2, 0.5, 0.25] } }";
  EXPECT_EQ(geometry_faults(with_shape(turned_ball)), "");
  EXPECT_NE(geometry_faults(with_shape(with(turned_ball, "radius = 0.195", "radius = 0.24"))), "");
}

TEST(CheckBodies, RefusesABodyWithoutParticles) {
  EXPECT_EQ(geometry_faults(small_scene, {"bodies.0.shape.radius=0.001"}),
            "s.toml:9:1: body 'ball' is too small to hold a particle; make it larger, the cells of 0.05 m smaller, or "
            "particles_per_cell greater than 8");
}

TEST(CheckBodies, RefusesOverlapUnlessAllowed) {
  const std::string cube = second_body("{ type = \"box\", lower = [0.6, 0.4, 0.2], upper = [0.9, 0.6, 0.4] }");
  const std::string sentence = geometry_faults(small_scene + cube);
  // 194 of the points 0.025 (i + 1/2) lie in the cube and in the ball.
  EXPECT_EQ(sentence.substr(0, 54), "s.toml:13:1: body 'second' overlaps body 'ball' in 194");
  EXPECT_NE(sentence.find("particles; move one of them, or set allow_overlap = true to let the first body win"),
            std::string::npos);
  EXPECT_EQ(geometry_faults(small_scene + cube, {"allow_overlap=true"}), "");
}

TEST(CheckBodies, AcceptsBodiesThatTouch) {
  const std::string box = "{ type = \"box\", lower = [0.1, 0.1, 0.1], upper = [0.4, 0.4, 0.4] }";
  EXPECT_EQ(
      geometry_faults(with_shape(box) + second_body("{ type = \"box\", lower = [0.4, 0.1, 0.1], upper = [0.6, 0.4, 0.4] }")),
      "");
}

TEST(CheckBodies, FindsABodyBetweenThePointsOfACoarseOne) {
  // Around a corner of the cells: no point of the second body, one per cell, lies in the first; all of the first's lie in
  // it.
  const std::string small = with_shape("{ type = \"sphere\", center = [0.5, 0.5, 0.25], radius = 0.03 }");
  const std::string large =
      second_body("{ type = \"sphere\", center = [0.5, 0.5, 0.25], radius = 0.2 }") + "particles_per_cell = 1\n";
  EXPECT_NE(geometry_faults(small + large).find("body 'second' overlaps body 'ball' in 8 particles"), std::string::npos);
}

TEST(CheckBodies, TellsAllFaults) {
  const std::string scene = small_scene + second_body("{ type = \"sphere\", center = [0.1, 0.1, 0.1], radius = 0.2 }");
  const std::string faults = geometry_faults(scene, {"bodies.0.shape.radius=0.001"});
  EXPECT_NE(faults.find("body 'ball' is too small"), std::string::npos);
  EXPECT_NE(faults.find("\ns.toml:13:1: body 'second' reaches from"), std::string::npos);
}

TEST(CheckBodies, KnowsScenesWithoutAFile) {
  Scene scene = parsed(small_scene);
  scene.body_places.clear();
  scene.bodies[0].shape.kind = Plane{Vec3::Zero(), Vec3::UnitZ()};
  EXPECT_EQ(geometry_faults(scene), "body 'ball' contains a plane or complement, which is for colliders only");
}

TEST(CheckBodies, RefusesAtOnceWhatReachesBeyondAllCounting) {
  for (const std::string size : {"1e4", "1e9", "1e30", "1e99"}) {
    const std::string box = "{ type = \"box\", lower = [0, 0, 0], upper = [" + size + ", " + size + ", " + size +
                            "], rotation = { angle = 30 } }";
    EXPECT_EQ(geometry_faults(with_shape(box)).substr(0, 36), "s.toml:9:1: body 'ball' reaches from") << size;
  }
}

TEST(CheckBodies, CountsOnlyNearTheBody) {
  // 4e8 tiles
  const std::string large = with(small_scene, "upper = [1, 1, 0.5]", "upper = [2000, 2000, 800]");
  EXPECT_EQ(
      geometry_faults(large, {"domain.cell_size=0.5", "bodies.0.shape.radius=10", "bodies.0.shape.center=[1500,900,100]"}),
      "");
  const std::string full = with(small_scene, "upper = [1, 1, 0.5]", "upper = [200, 200, 200]");
  EXPECT_EQ(geometry_faults(full, {"domain.cell_size=0.1", "bodies.0.shape.radius=100",
                                   "bodies.0.shape.center=[100,100,100]", "bodies.0.particles_per_cell=64"}),
            "s.toml:9:1: body 'ball' would be filled with some 3e+11 particles");
}

}  // namespace
}  // namespace bulkley::scene_test::check_bodies_test
