// [magnetics] of a scene: its sources, and what they have to agree on with the rest.

#include <gtest/gtest.h>

#include "support/scene_text.hpp"

namespace bulkley::scene_test::magnetics_keys_test {
namespace {

const std::string material = "[materials.fluid.magnetic]\nlaw = \"linear\"\nsusceptibility = 2\n";
const std::string coil = "[[magnetics.sources]]\nkind = \"coil\"\ncenter = [0, 0, 0.5]\nradius = 0.02\ncurrent = 100\n";

std::string fault(const std::string& text) { return faults_of(small_scene + text); }

TEST(MagneticsKeys, SourcesAreReadAndWrittenAgain) {
  const Scene scene = parsed(
      small_scene + material + "[magnetics]\nlargest_interval = 0.01\nmixing = \"linear\"\n" + coil +
      "amplitude = \"sin(t)\"\n[[magnetics.sources]]\nkind = \"box_magnet\"\ncenter = [0, 0, 1]\nsizes = [0.1, 0.2, 0.3]\n"
      "remanence = 1.3\n[[magnetics.sources]]\nkind = \"uniform\"\nfield = [\"1\", \"0\", \"2e4*t\"]\n");
  ASSERT_TRUE(scene.magnetics);
  ASSERT_EQ(scene.magnetics->sources.size(), 3u);
  EXPECT_EQ(scene.magnetics->mixing, Mixing::linear);
  EXPECT_EQ(std::get<Coil>(scene.magnetics->sources[0].kind).current, 100.0);
  EXPECT_EQ(scene.magnetics->sources[0].amplitude, "sin(t)");
  EXPECT_EQ(std::get<BoxMagnet>(scene.magnetics->sources[1].kind).sizes, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(std::get<UniformField>(scene.magnetics->sources[2].kind).field.text[2], "2e4*t");
  const Scene again = parse_scene(scene.effective_text, "e.toml", {});
  EXPECT_EQ(again.effective_text, scene.effective_text);
}

TEST(MagneticsKeys, MaterialsAndFieldsNeedEachOther) {
  EXPECT_NE(fault(material).find("[materials.fluid.magnetic] needs [magnetics]"), std::string::npos);
  EXPECT_NE(fault("[output]\nmagnetic_field = true\n").find("'output.magnetic_field' needs [magnetics]"), std::string::npos);
  EXPECT_NE(fault("[magnetics]\n" + coil).find("[magnetics] needs a material with a table 'magnetic'"), std::string::npos);
}

TEST(MagneticsKeys, PresetsBringTheirMagnetism) {
  const std::vector<std::string> preset = {"materials.fluid.preset=mrf_132dg"};
  const Scene scene = parsed(small_scene + "[magnetics]\n" + coil, preset);
  ASSERT_TRUE(scene.materials[0].magnetisation);
  EXPECT_TRUE(field_yield(scene.materials[0].material).given());
  // A table takes the place of all of it.
  const Scene other = parsed(small_scene + material + "[magnetics]\n" + coil, preset);
  EXPECT_EQ(other.materials[0].magnetisation->law, Magnetisation::Law::linear);
  EXPECT_FALSE(field_yield(other.materials[0].material).given());
}

TEST(MagneticsKeys, SourcesThatMakeNoSense) {
  const auto with = [](const std::string& sources) { return fault(material + "[magnetics]\n" + sources); };
  EXPECT_EQ(with(coil), "");
  EXPECT_NE(with("sources = []\n").find("it must hold at least one source"), std::string::npos);
  EXPECT_NE(with(coil + "amplitude = \"2*x\"\n").find("amplitude' is no formula of t"), std::string::npos);
  EXPECT_NE(with(coil + "axis = [0, 0, 0]\n").find("has no length"), std::string::npos);
  EXPECT_NE(with(coil + "moves_with = \"rod\"\n").find("which is no collider"), std::string::npos);
  EXPECT_NE(with(coil + "amplitude = \"t\"\n").find("needs 'largest_interval' above 0"), std::string::npos);
  EXPECT_NE(fault(material + "[magnetics]\nmixing = \"layers\"\nsolver = \"petsc\"\n" + coil).find("which solves for"),
            std::string::npos);
  EXPECT_NE(with(coil + "radios = 1\n").find("did you mean 'radius'?"), std::string::npos);
}

std::string magnetic_faults(const std::string& sources) {
  try {
    check_magnetics(parsed(small_scene + material + "[magnetics]\nlargest_interval = 0.1\n" + sources));
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

// The ball has its middle at (0.5, 0.5, 0.25) and a radius of 0.2.
TEST(MagneticsKeys, NoMaterialInsideAMagnet) {
  const auto source = [](const std::string& keys) { return "[[magnetics.sources]]\n" + keys; };
  const std::string inside = "inside body 'ball'";
  for (const char* in :
       {"kind = \"dipole\"\ncenter = [0.5, 0.6, 0.3]\nmoment = 1\n",
        "kind = \"coil\"\ncenter = [0.5, 0.5, 0.25]\nradius = 0.1\ncurrent = 1\n",
        "kind = \"coil\"\ncenter = [0.8, 0.5, 0.25]\nradius = 0.15\ncurrent = 1\n",
        "kind = \"cylinder_magnet\"\ncenter = [0.5, 0.5, 0.47]\nradius = 0.1\nlength = 0.1\nremanence = 1\n",
        "kind = \"box_magnet\"\ncenter = [0.5, 0.5, 0.0]\nsizes = [0.2, 0.2, 0.2]\nremanence = 1\n"})
    EXPECT_NE(magnetic_faults(source(in)).find(inside), std::string::npos) << in << magnetic_faults(source(in));
  for (const char* out :
       {"kind = \"dipole\"\ncenter = [0.5, 0.8, 0.3]\nmoment = 1\n",
        "kind = \"coil\"\ncenter = [0.5, 0.5, 0.25]\nradius = 0.3\ncurrent = 1\n",
        "kind = \"cylinder_magnet\"\ncenter = [0.5, 0.5, 0.5]\nradius = 0.1\nlength = 0.1\nremanence = 1\n"})
    EXPECT_EQ(magnetic_faults(source(out)), "");
}

TEST(MagneticsKeys, FormulasAreFieldsOfMagnets) {
  const auto formula = [](const std::string& field) {
    return magnetic_faults("[[magnetics.sources]]\nkind = \"formula\"\nfield = " + field + "\n");
  };
  EXPECT_EQ(formula("[\"-5e3*x\", \"-5e3*y\", \"1e5 + 1e4*z\"]"), "");
  EXPECT_EQ(formula("[\"x*x - y*y + t\", \"-2*x*y\", \"1\"]"), "");
  EXPECT_NE(formula("[\"0\", \"0\", \"1e5 + 1e4*z\"]").find("its divergence at"), std::string::npos);
  EXPECT_NE(formula("[\"0\", \"1e4*x\", \"1e4\"]").find("its curl at"), std::string::npos);
  EXPECT_NE(formula("[\"0\", \"t < 0.2 ? 0 : 1e4*x\", \"1e4\"]").find("its curl at"), std::string::npos);
}

}  // namespace
}  // namespace bulkley::scene_test::magnetics_keys_test
