// The tables [materials.NAME] of a scene.

#include <gtest/gtest.h>

#include <cmath>

#include "bulkley/material/preset.hpp"
#include "unit/config/scene_text.hpp"

namespace bulkley::scene_test {
namespace {

const HerschelBulkley::Parameters& fluid(const Scene& scene) {
  return std::get<HerschelBulkley>(scene.materials.at(0).material).parameters;
}

TEST(SceneMaterials, PresetsByName) {
  for (const Preset& preset : presets()) {
    const Scene scene = parsed(small_scene, {"materials.fluid.preset=" + std::string(preset.name)});
    EXPECT_EQ(scene.materials[0].name, "fluid");
    EXPECT_EQ(fluid(scene).density, preset.material.parameters.density);
    EXPECT_EQ(fluid(scene).eta, preset.material.parameters.eta);
  }
  EXPECT_EQ(
      faults_of(with_material("preset = \"creme\"\n")),
      "s.toml:8:10: 'materials.fluid.preset' is \"creme\"; it must be one of \"cream\", \"oobleck\", \"pie\"; did you mean "
      "\"cream\"?");
}

TEST(SceneMaterials, PresetsWithSingleParametersChanged) {
  const HerschelBulkley::Parameters cream = find_preset("cream")->material.parameters;
  const Scene yue = parsed(with_material("preset = \"cream\"\neta = 5\n"));
  EXPECT_EQ(fluid(yue).eta, 5.0);
  EXPECT_EQ(fluid(yue).sigma_Y, cream.sigma_Y);
  EXPECT_EQ(fluid(yue).h, cream.h);
  const Scene rheometer = parsed(with_material("preset = \"cream\"\nyield_stress = 10\n"));
  EXPECT_DOUBLE_EQ(fluid(rheometer).sigma_Y, 10.0 * std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(fluid(rheometer).eta, cream.eta);
  EXPECT_EQ(fluid(rheometer).h, cream.h);
  EXPECT_EQ(fluid(rheometer).bulk_modulus, cream.bulk_modulus);
}

const std::string elastic = "law = \"herschel_bulkley\"\ndensity = 1000\nbulk_modulus = 1e5\nshear_modulus = 1e3\n";

TEST(SceneMaterials, HerschelBulkleyInBothConventions) {
  const Scene yue = parsed(with_material(elastic + "sigma_Y = 31.9\neta = 27.2\nh = 0.22\n"));
  EXPECT_EQ(fluid(yue).sigma_Y, 31.9);
  EXPECT_EQ(fluid(yue).eta, 27.2);
  EXPECT_EQ(fluid(yue).h, 0.22);
  // The same foam as a shear rheometer reports it: tau_y = 31.9 / sqrt 3, K = 27.2 * 2^-0.61.
  const Scene rheometer =
      parsed(with_material(elastic + "yield_stress = 18.4175\nconsistency = 17.82135\nflow_index = 0.22\n"));
  EXPECT_NEAR(fluid(rheometer).sigma_Y, 31.9, 1e-4);
  EXPECT_NEAR(fluid(rheometer).eta, 27.2, 1e-5);
  EXPECT_EQ(fluid(rheometer).h, 0.22);
  EXPECT_EQ(fluid(rheometer).shear_modulus, 1e3);
}

TEST(SceneMaterials, ConventionsAreNeverMixed) {
  EXPECT_EQ(faults_of(with_material(elastic + "sigma_Y = 31.9\nconsistency = 17\nh = 0.22\n")),
            "s.toml:13:1: [materials.fluid] mixes 'sigma_Y' (Yue's convention) with 'consistency' (the shear rheometer's); "
            "give one "
            "or the other");
  EXPECT_EQ(faults_of(with_material("preset = \"cream\"\nh = 0.3\nflow_index = 0.3\n")),
            "s.toml:10:1: [materials.fluid] mixes 'h' (Yue's convention) with 'flow_index' (the shear rheometer's); give "
            "one or the "
            "other");
}

TEST(SceneMaterials, MissingParameters) {
  EXPECT_EQ(faults_of(with_material(elastic + "sigma_Y = 31.9\n")),
            "s.toml:7:1: required key 'eta' is missing in [materials.fluid]\n"
            "s.toml:7:1: required key 'h' is missing in [materials.fluid]");
  EXPECT_EQ(faults_of(with_material(elastic + "flow_index = 0.3\nconsistency = 1\n")),
            "s.toml:7:1: required key 'yield_stress' is missing in [materials.fluid]");
  EXPECT_EQ(faults_of(with_material(elastic)),
            "s.toml:7:1: [materials.fluid] needs 'yield_stress', 'consistency' and 'flow_index' (shear rheometer) or "
            "'sigma_Y', 'eta' "
            "and 'h' (Yue et al. 2015)");
  EXPECT_EQ(faults_of(with_material("density = 1\n")), "s.toml:7:1: [materials.fluid] needs 'law' or 'preset'");
  EXPECT_EQ(faults_of(with_material("law = \"neo_hookean\"\npreset = \"pie\"\n")),
            "s.toml:9:1: [materials.fluid] has both 'law' and 'preset'; give one");
  EXPECT_EQ(faults_of(small_scene, {"materials={}"}),
            "--set materials={}: [materials] names 0 materials; it must name between 1 and 255");
}

TEST(SceneMaterials, Ranges) {
  const std::string flow = "sigma_Y = 0\neta = 0\nh = 3\n";
  EXPECT_EQ(faults_of(with_material(elastic + flow)), "");
  EXPECT_EQ(faults_of(with_material(elastic + "sigma_Y = 0\neta = 0\nh = 3.1\n")),
            "s.toml:14:5: 'materials.fluid.h' is 3.1; it must be at least 0.1 and at most 3");
  EXPECT_EQ(faults_of(with_material(with(elastic + flow, "density = 1000", "density = 0"))),
            "s.toml:9:11: 'materials.fluid.density' is 0; it must be greater than 0");
  EXPECT_EQ(faults_of(with_material(with(elastic + flow, "shear_modulus = 1e3", "shear_modulus = -1"))),
            "s.toml:11:17: 'materials.fluid.shear_modulus' is -1; it must be at least 0");
  EXPECT_EQ(faults_of(with_material(elastic + flow + "viscocity = 3\n")).substr(0, 62),
            "s.toml:15:1: unknown key 'viscocity' in [materials.fluid]; kno");
}

TEST(SceneMaterials, NeoHookeanByEitherPair) {
  const std::string law = "law = \"neo_hookean\"\ndensity = 900\n";
  const auto parameters = [](const Scene& scene) { return std::get<NeoHookean>(scene.materials.at(0).material).parameters; };
  const auto moduli = parameters(parsed(with_material(law + "bulk_modulus = 2e5\nshear_modulus = 1e5\n")));
  EXPECT_EQ(moduli.density, 900.0);
  EXPECT_EQ(moduli.bulk_modulus, 2e5);
  EXPECT_EQ(moduli.shear_modulus, 1e5);
  const auto engineering = parameters(parsed(with_material(law + "youngs_modulus = 3e5\npoisson_ratio = 0.25\n")));
  EXPECT_DOUBLE_EQ(engineering.bulk_modulus, 2e5);
  EXPECT_DOUBLE_EQ(engineering.shear_modulus, 1.2e5);

  EXPECT_EQ(faults_of(with_material(law + "bulk_modulus = 2e5\npoisson_ratio = 0.25\n")),
            "s.toml:11:1: [materials.fluid] mixes 'bulk_modulus' (one pair) with 'poisson_ratio' (the other pair); give one "
            "or the "
            "other");
  EXPECT_EQ(faults_of(with_material(law + "youngs_modulus = 3e5\n")),
            "s.toml:7:1: required key 'poisson_ratio' is missing in [materials.fluid]");
  EXPECT_EQ(
      faults_of(with_material(law)),
      "s.toml:7:1: [materials.fluid] needs 'bulk_modulus' and 'shear_modulus', or 'youngs_modulus' and 'poisson_ratio'");
  EXPECT_EQ(faults_of(with_material(law + "youngs_modulus = 3e5\npoisson_ratio = 0.5\n")),
            "s.toml:11:17: 'materials.fluid.poisson_ratio' is 0.5; it must be greater than -1 and less than 0.5");
}

TEST(SceneMaterials, AtMost255) {
  std::string text = small_scene;
  for (int m = 1; m < 255; ++m) text += "[materials.m" + std::to_string(m) + "]\npreset = \"pie\"\n";
  EXPECT_EQ(parsed(text, {"bodies.0.material=m254"}).bodies[0].material_index, 254);
  EXPECT_EQ(faults_of(text + "[materials.m255]\npreset = \"pie\"\n"),
            "s.toml:7:1: [materials] names 256 materials; it must name between 1 and 255");
}

}  // namespace
}  // namespace bulkley::scene_test
