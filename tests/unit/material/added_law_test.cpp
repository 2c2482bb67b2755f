// A law that a program adds must do what the same law does inside the library.

#include "bulkley/material/add_law.hpp"

#include <gtest/gtest.h>

#include <random>

#include "bulkley/base/error.hpp"
#include "kernel/stress_update.hpp"
#include "scene/scene.hpp"

namespace bulkley::added_law_test {

// Sand under another name, with one number of its own.
struct CopiedSand : DruckerPrager {
  static constexpr const char* law_name = "copied_sand";
  static constexpr int n_variables = 1;
  CharacteristicStress characteristic_stress(double rate) const { return {7.0 * rate, 3.0}; }
};
// With the name of a law of the library.
struct SecondHencky : Hencky {
  static constexpr const char* law_name = "hencky";
};

}  // namespace bulkley::added_law_test

namespace bulkley {

template <>
struct LawKeys<added_law_test::CopiedSand> : PlainKeys<added_law_test::CopiedSand> {
  static const config::Keys<Input>& table() {
    using P = DruckerPrager::Parameters;
    static const auto keys =
        config::Keys<P>("A copy.")
            .key("density", [](auto& p) -> auto& { return p.density; },
                 {.about = "Density.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = "**required**"})
            .key("bulk_modulus", [](auto& p) -> auto& { return p.bulk_modulus; },
                 {.about = "Stiffness.", .unit = "Pa", .default_text = "**required**"})
            .key("shear_modulus", [](auto& p) -> auto& { return p.shear_modulus; },
                 {.about = "Stiffness.", .unit = "Pa", .default_text = "**required**"})
            .key("friction_angle", &P::friction_angle,
                 {.about = "Angle.", .unit = "degrees", .default_text = "**required**"});
    return keys;
  }
};

template <>
struct LawKeys<added_law_test::SecondHencky> : PlainKeys<added_law_test::SecondHencky> {
  static const config::Keys<Input>& table() {
    static const config::Keys<Input> keys("Another one.");
    return keys;
  }
};

}  // namespace bulkley

namespace bulkley::added_law_test {
namespace {

constexpr DruckerPrager::Parameters sand_parameters() {
  DruckerPrager::Parameters p;
  p.density = 1500.0;
  p.bulk_modulus = 2e5;
  p.shear_modulus = 1e5;
  p.friction_angle = 30.0;
  return p;
}

void add_laws_once() {
  static const bool once = [] {
    add_law<CopiedSand>();
    return true;
  }();
  (void)once;
}

std::string scene_text(const std::string& material) {
  return "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\ncell_size = 0.1\n[time]\nend = 1\n[materials.m]\n" + material +
         "\n[[bodies]]\nname = \"b\"\nmaterial = \"m\"\n"
         "shape = { type = \"box\", lower = [0.3, 0.3, 0.3], upper = [0.6, 0.6, 0.6] }\nparticles_per_cell = 8\n";
}

const std::string copied_table =
    "law = \"copied_sand\"\ndensity = 1500\nbulk_modulus = 2e5\nshear_modulus = 1e5\nfriction_angle = 30\n";

Scene parsed(const std::string& material) {
  add_laws_once();
  return parse_scene(scene_text(material), "scene.toml", {});
}

std::string fault_of(const std::string& material) {
  try {
    parsed(material);
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

// Particles in states that differ, some of which yield.
void fill(ParticleSet& particles, LocalIndex n) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  particles.resize(n);
  for (LocalIndex p = 0; p < n; ++p) {
    for (int c = 0; c < 9; ++c) particles.real(Field::affine_velocity, c)[p] = 20.0 * number(random);
    for (int c = 0; c < 6; ++c) particles.real(Field::left_cauchy_green, c)[p] = c < 3 ? 1.0 : 0.0;
    for (int c = 0; c < 6; ++c) particles.real(Field::kirchhoff_stress, c)[p] = 0.0;
    particles.real(Field::volume_ratio)[p] = 1.0 + 0.001 * number(random);
    particles.real(Field::reference_volume)[p] = 1e-6;
    particles.real(Field::plastic_shear_rate)[p] = particles.real(Field::plastic_dissipation)[p] = 0.0;
    particles.material()[p] = 0;
    particles.id()[p] = p;
  }
}

double difference(const ParticleSet& a, const ParticleSet& b, Field field, int component, double scale) {
  double largest = 0.0;
  for (LocalIndex p = 0; p < a.size(); ++p)
    largest = std::max(largest, std::fabs(a.real(field, component)[p] - b.real(field, component)[p]) / scale);
  return largest;
}

// The library fuses products and sums where this file does not, so both agree to rounding.
TEST(AddedLaw, DoesWhatTheSameLawDoesInsideTheLibrary) {
  const Material inside = DruckerPrager{sand_parameters()};
  const Material outside = AddedLaw{{std::make_shared<AddedLawModelOf<CopiedSand>>(CopiedSand{{sand_parameters()}})}};
  ParticleSet a({Field::kirchhoff_stress, Field::hardening}), b({Field::kirchhoff_stress, Field::added_law_variables});
  fill(a, 50);
  fill(b, 50);
  set_internal_variables(inside, 0, a);
  set_internal_variables(outside, 0, b);
  StepBounds bounds_a, bounds_b;
  for (int step = 0; step < 5; ++step) {
    stress_update(inside, 0, Field::affine_velocity, 1e-4, a, bounds_a);
    stress_update(outside, 0, Field::affine_velocity, 1e-4, b, bounds_b);
  }
  for (int c = 0; c < 6; ++c) {
    EXPECT_LT(difference(a, b, Field::left_cauchy_green, c, 1.0), 1e-13);
    EXPECT_LT(difference(a, b, Field::kirchhoff_stress, c, 2e5), 1e-13);
  }
  EXPECT_LT(difference(a, b, Field::volume_ratio, 0, 1.0), 1e-14);
  EXPECT_LT(difference(a, b, Field::plastic_shear_rate, 0, 20.0), 1e-10);
  double largest_hardening = 0.0;
  for (LocalIndex p = 0; p < a.size(); ++p) {
    largest_hardening = std::max(largest_hardening, a.real(Field::hardening)[p]);
    EXPECT_NEAR(b.real(Field::added_law_variables, 0)[p], a.real(Field::hardening)[p], 1e-13);
    for (int k = 1; k < n_added_law_variables; ++k) EXPECT_EQ(b.real(Field::added_law_variables, k)[p], 0.0);
  }
  EXPECT_GT(largest_hardening, 1e-4);
  EXPECT_NEAR(bounds_a.motion.wave_speed.value, bounds_b.motion.wave_speed.value, 1e-12 * bounds_a.motion.wave_speed.value);
  EXPECT_FALSE(bounds_a.failed() || bounds_b.failed());
}

TEST(AddedLaw, IsNamedAndReadInScenes) {
  const Scene scene = parsed(copied_table);
  const Material& material = scene.materials.at(0).material;
  EXPECT_STREQ(law_name(material), "copied_sand");
  EXPECT_TRUE(flows(material));
  EXPECT_EQ(std::visit([](const auto& law) { return law.density(); }, material), 1500.0);
  ASSERT_EQ(internal_variables(material).size(), 1u);
  EXPECT_EQ(internal_variables(material)[0], Field::added_law_variables);
  EXPECT_EQ(characteristic_stress(material, 2.0)->total, 14.0);
  EXPECT_EQ(characteristic_stress(material, 2.0)->yield, 3.0);
}

TEST(AddedLaw, IsWrittenIntoTheEffectiveScene) {
  const Scene scene = parsed(copied_table);
  const Scene again = parse_scene(scene.effective_text, "effective.toml", {});
  EXPECT_EQ(again.effective_text, scene.effective_text);
  EXPECT_NE(scene.effective_text.find("law = \"copied_sand\""), std::string::npos) << scene.effective_text;
  EXPECT_NE(input_reference().find("law = \"copied_sand\""), std::string::npos);
}

TEST(AddedLaw, FaultsOfItsTableAreNamed) {
  EXPECT_NE(fault_of(copied_table + "frictoin = 3\n").find("unknown key 'frictoin'"), std::string::npos);
  EXPECT_NE(fault_of("law = \"copied_sand\"\ndensity = 1500\n").find("bulk_modulus"), std::string::npos);
  std::string steep = copied_table;
  steep.replace(steep.find("= 30"), 4, "= 80");
  EXPECT_NE(fault_of(steep).find("friction_angle - hardening_drop = 80 must be"), std::string::npos) << fault_of(steep);
  EXPECT_NE(fault_of("law = \"copied_sandd\"\n").find("did you mean \"copied_sand\""), std::string::npos)
      << fault_of("law = \"copied_sandd\"\n");
}

// Ranges hold for a program that fills the parameters itself, too.
TEST(AddedLaw, ParametersOfAProgramAreCheckedAgainstTheRangesOfTheKeys) {
  const auto fault_with_density = [](double density) {
    DruckerPrager::Parameters p = sand_parameters();
    p.density = density;
    return material_fault(AddedLaw{{std::make_shared<AddedLawModelOf<CopiedSand>>(CopiedSand{{p}})}}).value_or("");
  };
  EXPECT_EQ(fault_with_density(1500.0), "");
  EXPECT_EQ(fault_with_density(-1.0), "density = -1 must be greater than 0");
  EXPECT_EQ(fault_with_density(INFINITY), "density = inf must be finite");
  EXPECT_EQ(fault_with_density(NAN), "density is not given; it must be greater than 0");
}

TEST(AddedLaw, NamesAreTakenOnce) {
  add_laws_once();
  EXPECT_THROW(add_law<SecondHencky>(), UsageError);
  EXPECT_THROW(add_law<CopiedSand>(), UsageError);
}

}  // namespace
}  // namespace bulkley::added_law_test
