// The tables [materials.NAME] of a scene.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <utility>
#include <variant>
#include <vector>

#include "bulkley/config/toml.hpp"
#include "material/material_keys.hpp"
#include "material/preset.hpp"
#include "support/scene_text.hpp"

namespace bulkley::scene_test::scene_materials_test {
namespace {

const HerschelBulkley::Parameters& fluid(const Scene& scene) {
  return std::get<HerschelBulkley>(scene.materials.at(0).material).parameters;
}

// The parameters of a material as a scene would give them.
std::string text_of(const Material& material) {
  return config::print_toml(config::Codec<std::vector<NamedMaterial>>::write({{"fluid", material, {}}}));
}

TEST(SceneMaterials, PresetsByName) {
  std::string names;
  for (const Preset& preset : presets()) {
    const Scene scene = parsed(small_scene, {"materials.fluid.preset=" + std::string(preset.name)});
    EXPECT_EQ(scene.materials[0].name, "fluid");
    EXPECT_EQ(text_of(scene.materials[0].material), text_of(preset.material));
    names += (names.empty() ? "\"" : ", \"") + std::string(preset.name) + "\"";
  }
  EXPECT_EQ(faults_of(with_material("preset = \"creme\"\n")),
            "s.toml:8:10: 'materials.fluid.preset' is \"creme\"; it must be one of " + names + "; did you mean \"cream\"?");
}

const std::string magnetic =
    "[materials.fluid.magnetic]\nlaw = \"exponential\"\nsaturation = 4e5\nsusceptibility = 5\nyield = \"power\"\n"
    "yield_saturation = 4e4\nyield_field = 1e5\n";

TEST(SceneMaterials, MagneticTablesAreReadAndWrittenAgain) {
  const std::string field = "[[magnetics.sources]]\nkind = \"uniform\"\nfield = [\"0\", \"0\", \"1e4\"]\n";
  const Scene scene = parsed(small_scene + magnetic + field);
  ASSERT_TRUE(scene.materials[0].magnetisation);
  EXPECT_EQ(scene.materials[0].magnetisation->law, Magnetisation::Law::exponential);
  EXPECT_EQ(scene.materials[0].magnetisation->saturation, 4e5);
  EXPECT_EQ(scene.materials[0].magnetisation->initial_susceptibility(), 5.0);
  EXPECT_EQ(field_yield(scene.materials[0].material), (FieldYield{FieldYield::Form::power, 4e4, 1e5}));
  const Scene again = parse_scene(scene.effective_text, "e.toml", {});
  EXPECT_EQ(again.effective_text, scene.effective_text);
  EXPECT_EQ(again.materials[0].magnetisation->saturation, 4e5);

  // Without a field a magnetic preset is a fluid like others.
  const Scene plain = parsed(small_scene, {"materials.fluid.preset=mrf_132dg"});
  EXPECT_FALSE(plain.materials[0].magnetisation);
  EXPECT_FALSE(field_yield(plain.materials[0].material).given());
}

TEST(SceneMaterials, MagneticTablesThatMakeNoSense) {
  const auto fault = [](const std::string& table) {
    return faults_of(small_scene + "[materials.fluid.magnetic]\n" + table);
  };
  EXPECT_NE(fault("law = \"langevin\"\nsusceptibility = 1\n").find("saturation"), std::string::npos);
  EXPECT_NE(fault("law = \"linear\"\nsusceptibility = 1\nsaturation = 1e4\n").find("a law that saturates"),
            std::string::npos);
  EXPECT_NE(fault("law = \"linear\"\nsusceptibility = 0\n").find("susceptibility"), std::string::npos);
  EXPECT_NE(fault("law = \"linear\"\nsusceptibility = 1\nyield_field = 1e5\n").find("yield = "), std::string::npos);
  EXPECT_NE(fault("law = \"linear\"\nsusceptibility = 1\nyield = \"tanh\"\nyield_field = 1e5\n").find("yield_saturation"),
            std::string::npos);
  const std::string linear =
      "[materials.fluid.magnetic]\nlaw = \"linear\"\nsusceptibility = 1\nyield = \"tanh\"\nyield_field = 1e5\n"
      "yield_saturation = 100\n";
  EXPECT_NE(faults_of(with_material("preset = \"water\"\n") + linear).find("needs a fluid that yields"), std::string::npos);
}

TEST(SceneMaterials, UncertainAndProposedPresetsCarryACaveat) {
  for (const Preset& preset : presets()) {
    const Scene scene = parsed(small_scene, {"materials.fluid.preset=" + std::string(preset.name)});
    EXPECT_EQ(scene.materials[0].caveat, caveat(preset));
    // The effective input names the law, whose numbers are then the scene's own.
    EXPECT_EQ(parse_scene(scene.effective_text, "e.toml", {}).materials[0].caveat, "");
  }
  EXPECT_NE(parsed(small_scene, {"materials.fluid.preset=ketchup"}).materials[0].caveat, "");
  EXPECT_EQ(parsed(small_scene).materials[0].caveat, "");
}

TEST(SceneMaterials, PresetsWithSingleParametersChanged) {
  const HerschelBulkley::Parameters cream = std::get<HerschelBulkley>(find_preset("cream")->material).parameters;
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

// --- every law ----------------------------------------------------------------------------------------------------------

struct LawText {
  const char* law;
  std::vector<std::string> required, optional;  // lines; the optional ones with values that are not the defaults
};
void PrintTo(const LawText& text, std::ostream* out) { *out << text.law; }

const std::vector<std::string> solid_lines{"density = 900", "bulk_modulus = 2e5", "shear_modulus = 1e5"};
std::vector<std::string> solid_and(std::vector<std::string> more) {
  more.insert(more.begin(), solid_lines.begin(), solid_lines.end());
  return more;
}

const LawText law_texts[] = {
    {"neo_hookean", solid_lines, {}},
    {"hencky", solid_lines, {}},
    {"fixed_corotated", solid_lines, {}},
    {"herschel_bulkley", solid_and({"sigma_Y = 30", "eta = 20", "h = 0.4"}), {"background_viscosity = 0.3"}},
    {"newtonian", {"density = 900", "bulk_modulus = 2e5", "viscosity = 0.1"}, {"tait_exponent = 1", "tension = false"}},
    {"oldroyd_b", solid_and({"relaxation_time = 0.1"}), {"solvent_viscosity = 0.2", "form = \"isochoric\""}},
    {"finite_viscoelastic",
     solid_and({"branch_shear_modulus = 1e4", "relaxation_time = 0.1"}),
     {"branch_bulk_modulus = 3e4", "bulk_relaxation_time = 0.7"}},
    {"thixotropic_herschel_bulkley",
     solid_and({"sigma_Y = 30", "eta = 20", "h = 0.4", "build_up = 0.1", "breakdown = 0.2"}),
     {"background_viscosity = 0.3", "kinetics = \"rheopectic\"", "rate_exponent = 1.2", "yield_exponent = 1.3",
      "consistency_exponent = 0.9", "residual_yield = 0.1", "residual_consistency = 0.25", "initial_structure = 0.5"}},
    {"drucker_prager",
     solid_and({"friction_angle = 30"}),
     {"cohesion = 10", "hardening_rise = 1", "hardening_decay = 0.3", "hardening_drop = 5"}},
    {"snow", solid_and({"critical_compression = 0.02", "critical_stretch = 0.01", "hardening = 8"}), {}},
};

std::string lines_of(const LawText& text, bool all) {
  std::string lines = std::string("law = \"") + text.law + "\"\n";
  for (const std::string& line : text.required) lines += line + "\n";
  if (all)
    for (const std::string& line : text.optional) lines += line + "\n";
  return lines;
}

class SceneLaws : public testing::TestWithParam<LawText> {};
INSTANTIATE_TEST_SUITE_P(Law, SceneLaws, testing::ValuesIn(law_texts), [](const auto& test) { return test.param.law; });

// All but AddedLaw, which has no keys of its own.
TEST(SceneMaterials, EveryLawIsTestedHere) { EXPECT_EQ(std::size(law_texts), std::variant_size_v<Material> - 1); }

TEST_P(SceneLaws, RoundTrip) {
  for (const bool all : {false, true}) {
    const Scene scene = parsed(with_material(lines_of(GetParam(), all)));
    const auto law_name = std::visit([](const auto& law) { return std::string(law.law_name); }, scene.materials[0].material);
    EXPECT_EQ(law_name, GetParam().law);
    const Scene again = parse_scene(scene.effective_text, "effective.toml", {});
    EXPECT_EQ(again.effective_text, scene.effective_text);
    EXPECT_EQ(text_of(again.materials[0].material), text_of(scene.materials[0].material));
  }
}

// Every key that may be left out changes the law where it is given.
TEST_P(SceneLaws, EveryOptionalKeyCounts) {
  const std::string plain = text_of(parsed(with_material(lines_of(GetParam(), false))).materials[0].material);
  for (const std::string& line : GetParam().optional) {
    const Scene scene = parsed(with_material(lines_of(GetParam(), false) + line + "\n"));
    EXPECT_NE(text_of(scene.materials[0].material), plain) << line;
  }
}

TEST_P(SceneLaws, EveryRequiredKeyIsMissed) {
  for (const std::string& line : GetParam().required) {
    const std::string key = line.substr(0, line.find(' '));
    EXPECT_EQ(faults_of(with_material(with(lines_of(GetParam(), false), line + "\n", ""))),
              "s.toml:7:1: required key '" + key + "' is missing in [materials.fluid]");
  }
}

TEST_P(SceneLaws, NumbersOutOfRangeAreRefused) {
  for (const bool optional : {false, true})
    for (const std::string& line : optional ? GetParam().optional : GetParam().required) {
      if (line.find('"') != std::string::npos || line.find("false") != std::string::npos) continue;
      const std::string key = line.substr(0, line.find(' '));
      const std::string faults =
          faults_of(with_material(with(lines_of(GetParam(), true), "\n" + line + "\n", "\n" + key + " = -1\n")));
      EXPECT_NE(faults.find("'materials.fluid." + key + "' is -1; it must be"), std::string::npos) << faults;
    }
}

// Solids take their stiffness as Young's modulus and Poisson's ratio as well.
TEST_P(SceneLaws, SolidsTakeEitherPairOfStiffness) {
  const std::string law = GetParam().law;
  const std::string moduli = "bulk_modulus = 2e5\nshear_modulus = 1e5\n",
                    young = "youngs_modulus = 3e5\npoisson_ratio = 0.25\n";
  const std::string lines = lines_of(GetParam(), true);
  if (law == "newtonian" || law == "oldroyd_b" || law.find("herschel_bulkley") != std::string::npos) {
    EXPECT_NE(faults_of(with_material(lines + young)).find("unknown key 'youngs_modulus'"), std::string::npos);
    return;
  }
  const Scene scene = parsed(with_material(with(lines, moduli, young)));
  std::visit(
      [](const auto& material) {
        if constexpr (requires { material.parameters.shear_modulus; }) {
          EXPECT_DOUBLE_EQ(material.parameters.bulk_modulus, 2e5);
          EXPECT_DOUBLE_EQ(material.parameters.shear_modulus, 1.2e5);
          EXPECT_EQ(material.parameters.density, 900.0);
        }
      },
      scene.materials[0].material);
  EXPECT_NE(faults_of(with_material(lines + young)).find("mixes 'bulk_modulus'"), std::string::npos);
  EXPECT_EQ(faults_of(with_material(with(lines, moduli, "youngs_modulus = 3e5\n"))),
            "s.toml:7:1: required key 'poisson_ratio' is missing in [materials.fluid]");
}

TEST(SceneMaterials, ThixotropicFlowInBothConventions) {
  const std::string start =
      "law = \"thixotropic_herschel_bulkley\"\ndensity = 1000\nbulk_modulus = 1e5\nshear_modulus = 1e3\nbuild_up = "
      "1\nbreakdown = 2\n";
  const auto parameters = [](const Scene& scene) {
    return std::get<ThixotropicHerschelBulkley>(scene.materials.at(0).material).parameters;
  };
  const auto yue = parameters(parsed(with_material(start + "sigma_Y = 31.9\neta = 27.2\nh = 0.22\n")));
  EXPECT_EQ(yue.sigma_Y, 31.9);
  EXPECT_EQ(yue.build_up, 1.0);
  EXPECT_EQ(yue.breakdown, 2.0);
  const auto rheometer =
      parameters(parsed(with_material(start + "yield_stress = 18.4175\nconsistency = 17.82135\nflow_index = 0.22\n")));
  EXPECT_NEAR(rheometer.sigma_Y, 31.9, 1e-4);
  EXPECT_NEAR(rheometer.eta, 27.2, 1e-5);
  EXPECT_EQ(rheometer.h, 0.22);
  EXPECT_EQ(rheometer.build_up, 1.0);
  EXPECT_NE(faults_of(with_material(start + "sigma_Y = 31.9\nconsistency = 17\nh = 0.22\n")).find("mixes 'sigma_Y'"),
            std::string::npos);
}

TEST(SceneMaterials, ParametersThatContradictEachOther) {
  const std::string sand = lines_of(law_texts[8], false);
  EXPECT_EQ(faults_of(with_material(sand + "hardening_drop = 30\n")),
            "s.toml:7:1: [materials.fluid]: friction_angle - hardening_drop = 0 must be above 0 and at most 60 degrees");
  EXPECT_NE(faults_of(with_material(sand + "hardening_rise = 90\n")).find("the largest friction angle"), std::string::npos);
}

TEST(SceneMaterials, APresetOfAnotherLawTakesItsKeys) {
  const Scene scene =
      parsed(with_material("preset = \"sand\"\nfriction_angle = 40\nyoungs_modulus = 1e6\npoisson_ratio = 0.2\n"));
  const auto& sand = std::get<DruckerPrager>(scene.materials[0].material).parameters;
  EXPECT_EQ(sand.friction_angle, 40.0);
  EXPECT_EQ(sand.density, 2200.0);
  EXPECT_EQ(sand.hardening_drop, 10.0);
  EXPECT_DOUBLE_EQ(sand.shear_modulus, 1e6 / 2.4);
  EXPECT_NE(faults_of(with_material("preset = \"water\"\neta = 40\n")).find("unknown key 'eta'"), std::string::npos);
}

// --- internal variables in frames -----------------------------------------------------------------------------------------

bool writes(const Scene& scene, const std::string& field) {
  return std::find(scene.output.fields.begin(), scene.output.fields.end(), field) != scene.output.fields.end();
}

TEST(SceneMaterials, FramesHoldTheInternalVariablesOfTheLawsByDefault) {
  const std::pair<const char*, const char*> pairs[] = {{"thixotropic_herschel_bulkley", "structure"},
                                                       {"drucker_prager", "hardening"},
                                                       {"snow", "plastic_volume_ratio"},
                                                       {"finite_viscoelastic", "viscous_left_cauchy_green"}};
  for (const LawText& text : law_texts) {
    const Scene scene = parsed(with_material(lines_of(text, false)));
    for (const auto& [law, field] : pairs) EXPECT_EQ(writes(scene, field), std::string(law) == text.law) << field;
    EXPECT_TRUE(writes(scene, "velocity"));
  }
  const Scene chosen = parsed(with_material(lines_of(law_texts[9], false)) + "[output]\nfields = [\"velocity\"]\n");
  EXPECT_EQ(chosen.output.fields, std::vector<std::string>{"velocity"});
  const Scene asked =
      parsed(with_material(lines_of(law_texts[9], false)) + "[output]\nfields = [\"plastic_volume_ratio\"]\n");
  EXPECT_EQ(asked.output.fields, std::vector<std::string>{"plastic_volume_ratio"});
}

TEST(SceneMaterials, AnInternalVariableThatNoLawHasIsRefused) {
  EXPECT_EQ(faults_of(small_scene + "[output]\nfields = [\"velocity\", \"structure\"]\n"),
            "s.toml:14:10: 'output.fields' names 'structure', which no law among the scene's materials has (structure of a "
            "thixotropic fluid, 0 broken down, 1 built up)");
}

TEST(SceneMaterials, FramesHoldTheCellMeanStressOfAnImplicitPressureWhereItIsListed) {
  const std::string listed = "[output]\nfields = [\"cell_mean_stress\"]\n";
  const std::vector<std::string> imex{"time.integrator=imex"};
  EXPECT_EQ(parse_scene(small_scene + listed, "s.toml", imex).output.fields, std::vector<std::string>{"cell_mean_stress"});
  const Scene unlisted = parse_scene(small_scene, "s.toml", imex);
  EXPECT_EQ(std::ranges::count(unlisted.output.fields, "cell_mean_stress"), 0);
  EXPECT_NE(faults_of(small_scene + listed)
                .find("'output.fields' names 'cell_mean_stress', which needs time.integrator = \"imex\""),
            std::string::npos);
}

TEST(SceneMaterials, FramesHoldTheStressOfImplicitViscosityWhereItIsListed) {
  const std::string listed = "[output]\nfields = [\"viscous_stress\"]\n";
  const std::vector<std::string> implicit{"time.integrator=imex", "time.viscosity=implicit"};
  EXPECT_EQ(parse_scene(small_scene + listed, "s.toml", implicit).output.fields, std::vector<std::string>{"viscous_stress"});
  EXPECT_EQ(std::ranges::count(parse_scene(small_scene, "s.toml", implicit).output.fields, "viscous_stress"), 0);
  EXPECT_NE(faults_of(small_scene + listed)
                .find("'output.fields' names 'viscous_stress', which needs time.viscosity = \"implicit\""),
            std::string::npos);
}

TEST(SceneMaterials, AtMost255) {
  std::string text = small_scene;
  for (int m = 1; m < 255; ++m) text += "[materials.m" + std::to_string(m) + "]\npreset = \"pie\"\n";
  EXPECT_EQ(parsed(text, {"bodies.0.material=m254"}).bodies[0].material_index, 254);
  EXPECT_EQ(faults_of(text + "[materials.m255]\npreset = \"pie\"\n"),
            "s.toml:7:1: [materials] names 256 materials; it must name between 1 and 255");
}

}  // namespace
}  // namespace bulkley::scene_test::scene_materials_test
