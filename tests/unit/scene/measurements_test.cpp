// [[output.front]] and [[output.gauge]] in a scene.
#include <gtest/gtest.h>

#include "scene/scene.hpp"
#include "support/scene_text.hpp"

namespace bulkley::scene_test::measurements_test {
namespace {

const std::string plate =
    "[[colliders]]\n"                                                                   // 13
    "name = \"plate\"\n"                                                                // 14
    "shape = { type = \"box\", lower = [0.8, 0.1, 0.1], upper = [0.95, 0.9, 0.4] }\n";  // 15
const std::string gauge = small_scene + plate + "[[output.gauge]]\nname = \"p1\"\n";    // 16, 17
const std::string front = small_scene + plate + "[[output.front]]\nname = \"tip\"\n";   // 16, 17

TEST(Measurements, AreRead) {
  const Scene scene = parsed(
      gauge +
      "face = \"x_upper\"\ncenter = [1, 0.5, 0.2]\nradius = 0.1\n[[output.gauge]]\nname = \"p2\"\ncollider = \"plate\"\n"
      "lower = [0.7, 0, 0]\nupper = [0.8, 1, 0.2]\n[[output.front]]\nname = \"tip\"\ndirection = [2, 0, 0]\nquantile = 0.9\n"
      "material = \"fluid\"\neye = [0, 0, 1]\nplane = 0.1\norigin = [0.1, 0, 0]\n[[output.front]]\nname = \"r\"\n"
      "axis = [0, 0, 1]\n");
  ASSERT_EQ(scene.output.gauges.size(), 2u);
  ASSERT_EQ(scene.output.fronts.size(), 2u);
  EXPECT_EQ(scene.output.gauges[0].face, FaceName::x_upper);
  EXPECT_EQ(scene.output.gauges[0].radius, 0.1);
  EXPECT_EQ(scene.output.gauges[0].collider_number, -1);
  EXPECT_EQ(scene.output.gauges[1].collider_number, 0);
  EXPECT_EQ(scene.output.fronts[0].material_number, 0);
  EXPECT_EQ(scene.output.fronts[0].plane, 0.1);
  EXPECT_EQ(scene.output.fronts[1].material_number, -1);
  EXPECT_EQ(parsed(scene.effective_text).effective_text, scene.effective_text);
  check_gauges(scene);
}

TEST(Measurements, OfNothingAreRefused) {
  const auto expect_fault = [](const std::string& text, const std::string& sentence) {
    EXPECT_EQ(faults_of(text), sentence);
  };
  expect_fault(gauge, "s.toml:16:1: [output.gauge.0] has neither 'face' nor 'collider'; give one of them");
  expect_fault(gauge + "face = \"z_lower\"\ncollider = \"plate\"\n",
               "s.toml:16:1: [output.gauge.0] has both 'face' and 'collider'; give one of them");
  expect_fault(gauge + "face = \"z_max\"\n",
               "s.toml:18:8: 'output.gauge.0.face' is \"z_max\"; it must be one of \"x_lower\", \"x_upper\", "
               "\"y_lower\", \"y_upper\", \"z_lower\", \"z_upper\"");
  expect_fault(gauge + "collider = \"plat\"\n",
               "s.toml:18:12: 'output.gauge.0.collider' is \"plat\", which is not in [[colliders]]; did you mean 'plate'?");
  expect_fault(gauge + "face = \"z_upper\"\n[boundaries]\nz_upper = \"open\"\n",
               "s.toml:18:8: 'output.gauge.0.face' is \"z_upper\", which is open: there is no wall on which to measure");
  expect_fault(gauge + "face = \"z_lower\"\nlower = [0, 0, 0]\n",
               "s.toml:19:1: [output.gauge.0] has 'lower' without 'upper'; give both or neither");
  expect_fault(gauge + "face = \"z_lower\"\nradius = 0.1\n",
               "s.toml:19:1: [output.gauge.0] has 'radius' without 'center'; give both or neither");
  expect_fault(gauge + "face = \"z_lower\"\nlower = [0, 0, 0]\nupper = [1, -1, 0]\n",
               "s.toml:20:9: 'output.gauge.0.upper' must not be less than 'lower' along any axis");
  expect_fault(front, "s.toml:16:1: [output.front.0] has neither 'direction' nor 'axis'; give one of them");
  expect_fault(front + "direction = [0, 0, 0]\n",
               "s.toml:18:13: 'output.front.0.direction' has no length; it must not be [0, 0, 0]");
  expect_fault(front + "direction = [1, 0, 0]\nmaterial = \"fluit\"\n",
               "s.toml:19:12: 'output.front.0.material' is \"fluit\", which is not in [materials]; did you mean 'fluid'?");
  expect_fault(front + "direction = [1, 0, 0]\neye = [0, 0, 0.1]\nplane = 0.2\n",
               "s.toml:19:7: 'output.front.0.eye' is at z = 0.1 and must be above the floor, 'plane' = 0.2");
}

TEST(Measurements, MixturesAreRefused) {
  const std::string text = faults_of(gauge + "face = \"z_lower\"\nlower = [0, 0, 0]\nupper = [1, 1, 0]\nradius = 1\n");
  EXPECT_NE(text.find("mixes 'lower' (a box) with 'radius' (a disc or ball)"), std::string::npos) << text;
}

// Columns of history.csv need different names.
TEST(Measurements, NamesThatAreTakenAreRefused) {
  const std::string text = faults_of(
      small_scene + plate + "[[output.gauge]]\nname = \"plate\"\nface = \"z_lower\"\n[[output.front]]\nname = \"a,b\"\n" +
      "axis = [0, 0, 1]\n[[output.front]]\nname = \"a_b\"\naxis = [0, 0, 1]\n");
  EXPECT_NE(text.find("s.toml:17:8: 'output.gauge.0.name' is \"plate\", which a collider has already"), std::string::npos)
      << text;
  EXPECT_NE(text.find("s.toml:23:8: 'output.front.1.name' is \"a_b\", which another entry of [output.front] has already"),
            std::string::npos)
      << text;
}

TEST(Measurements, EmptyPatchesAreRefused) {
  const auto refusal = [](const std::string& text) {
    try {
      check_gauges(parsed(text));
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(
      refusal(gauge + "face = \"x_upper\"\ncenter = [0.5, 0.5, 0.2]\nradius = 0.1\n"),
      "s.toml:16:1: gauge 'p1' covers nothing of face 'x_upper': the ball of 'radius' around 'center' must contain a part "
      "of it that lies in the domain");
  EXPECT_EQ(
      refusal(gauge + "collider = \"plate\"\nlower = [0, 0, 0]\nupper = [0.2, 1, 0.2]\n"),
      "s.toml:16:1: gauge 'p1' covers nothing of the surface of collider 'plate': the box from 'lower' to 'upper' must "
      "contain a part of it that lies in the domain");
  EXPECT_EQ(refusal(gauge + "face = \"x_upper\"\ncenter = [1, 0.5, 0.2]\nradius = 0.1\n"), "");
}

}  // namespace
}  // namespace bulkley::scene_test::measurements_test
