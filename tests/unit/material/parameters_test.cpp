#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "material/preset.hpp"
#include "support.hpp"

namespace bulkley::parameters_test {
namespace {

using material_test::foam;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

struct Entry {
  double HerschelBulkley::Parameters::*member;
  const char* name;
};
constexpr Entry entries[] = {
    {&HerschelBulkley::Parameters::density, "density"},
    {&HerschelBulkley::Parameters::bulk_modulus, "bulk_modulus"},
    {&HerschelBulkley::Parameters::shear_modulus, "shear_modulus"},
    {&HerschelBulkley::Parameters::sigma_Y, "sigma_Y"},
    {&HerschelBulkley::Parameters::eta, "eta"},
    {&HerschelBulkley::Parameters::h, "h"},
};

std::string fault_with(double HerschelBulkley::Parameters::*member, double value) {
  HerschelBulkley::Parameters p = foam().parameters;
  p.*member = value;
  return material_fault(HerschelBulkley{p}).value_or("");
}

TEST(ParameterFault, ValidParametersHaveNone) {
  using P = HerschelBulkley::Parameters;
  EXPECT_FALSE(material_fault(foam()));
  EXPECT_EQ(fault_with(&P::shear_modulus, 0.0), "");
  EXPECT_EQ(fault_with(&P::sigma_Y, 0.0), "");
  EXPECT_EQ(fault_with(&P::eta, 0.0), "");
  EXPECT_EQ(fault_with(&P::eta, infinity), "");
  EXPECT_EQ(fault_with(&P::h, 0.1), "");
  EXPECT_EQ(fault_with(&P::h, 3.0), "");
}

TEST(ParameterFault, NamesWhatIsMissingOrOutOfRange) {
  using P = HerschelBulkley::Parameters;
  for (const Entry& e : entries) {
    EXPECT_NE(fault_with(e.member, nan_value).find(std::string(e.name) + " is not given"), std::string::npos) << e.name;
    EXPECT_NE(fault_with(e.member, -1.0).find(std::string(e.name) + " = -1 must be"), std::string::npos) << e.name;
    if (e.member != &P::eta) {
      EXPECT_NE(fault_with(e.member, infinity), "") << e.name;
    }
  }
  EXPECT_NE(fault_with(&P::density, 0.0), "");
  EXPECT_NE(fault_with(&P::bulk_modulus, 0.0), "");
  EXPECT_NE(fault_with(&P::h, 0.0999), "");
  EXPECT_EQ(fault_with(&P::h, 3.001), "h = 3.001 must be at least 0.1 and at most 3");
}

TEST(ParameterFault, DefaultParametersAreRefused) {
  EXPECT_TRUE(material_fault(NeoHookean{}));
  EXPECT_TRUE(material_fault(HerschelBulkley{}));
}

// The rules that no single range can state.
TEST(ParameterFault, RulesOverSeveralParameters) {
  DruckerPrager::Parameters sand = std::get<DruckerPrager>(find_preset("sand")->material).parameters;
  EXPECT_FALSE(material_fault(DruckerPrager{sand}));
  sand.hardening_drop = sand.friction_angle;
  EXPECT_EQ(material_fault(DruckerPrager{sand}),
            "friction_angle - hardening_drop = 0 must be above 0 and at most 60 degrees");
  sand.hardening_drop = 0.0;
  sand.hardening_rise = 500.0;
  EXPECT_NE(material_fault(DruckerPrager{sand}).value_or("").find("largest friction angle"), std::string::npos);
  sand.hardening_rise = 1.0;
  sand.hardening_decay = 0.0;
  EXPECT_NE(material_fault(DruckerPrager{sand}).value_or("").find("hardening_decay"), std::string::npos);

  ThixotropicHerschelBulkley::Parameters fluid{foam().parameters};
  fluid.build_up = fluid.breakdown = 1.0;
  EXPECT_FALSE(material_fault(ThixotropicHerschelBulkley{fluid}));
  fluid.eta = infinity;
  EXPECT_EQ(material_fault(ThixotropicHerschelBulkley{fluid}), "eta = inf must be finite");
}

TEST(CharacteristicStress, OfFluidsOnly) {
  const HerschelBulkley::Parameters p = foam().parameters;
  const ShearRheometerConstants c = shear_rheometer_constants(p);
  const auto stress = characteristic_stress(foam(), 3.0);
  ASSERT_TRUE(stress);
  EXPECT_EQ(stress->yield, c.yield_stress);
  EXPECT_EQ(stress->total, c.yield_stress + c.consistency * std::pow(3.0, c.flow_index));
  EXPECT_EQ(characteristic_stress(Newtonian{{1000.0, 1e5, 0.5}}, 4.0)->total, 2.0);
  EXPECT_EQ(characteristic_stress(OldroydB{{1000.0, 1e5, 10.0, 0.2, 0.5}}, 4.0)->total, 10.0);
  EXPECT_FALSE(characteristic_stress(NeoHookean{{1000.0, 1e5, 1e3}}, 1.0));
}

TEST(ShearRheometer, ConstantsOfTheFoam) {
  const ShearRheometerConstants c = shear_rheometer_constants(foam().parameters);
  EXPECT_NEAR(c.yield_stress, 18.4175, 1e-4);
  EXPECT_NEAR(c.consistency, 17.82135, 1e-5);
  EXPECT_EQ(c.flow_index, 0.22);
}

TEST(ShearRheometer, ConversionsAreInverse) {
  HerschelBulkley::Parameters p = foam().parameters;
  const HerschelBulkley::Parameters before = p;
  set_flow(p, shear_rheometer_constants(p));
  for (const Entry& e : entries) EXPECT_NEAR(p.*e.member, before.*e.member, 1e-14 * before.*e.member) << e.name;
}

TEST(YoungsModulus, AgreesWithTheUniaxialTest) {
  const NeoHookean::Parameters p = from_youngs_modulus(1000.0, 2.6e5, 0.3);
  EXPECT_NEAR(p.shear_modulus, 1e5, 1e-9);
  EXPECT_NEAR(p.bulk_modulus, 2.6e5 / 1.2, 1e-9);
  const double youngs_modulus = 9.0 * p.bulk_modulus * p.shear_modulus / (3.0 * p.bulk_modulus + p.shear_modulus);
  EXPECT_NEAR(youngs_modulus, 2.6e5, 1e-8);
}

TEST(Preset, EveryOneIsValidAndFoundByName) {
  std::string names;
  for (const Preset& preset : presets()) {
    EXPECT_EQ(material_fault(preset.material).value_or(""), "") << preset.name;
    EXPECT_FALSE(preset.source.empty());
    const auto found = find_preset(preset.name);
    EXPECT_TRUE(found && found->material.index() == preset.material.index() && found->source == preset.source);
    EXPECT_LT(names.substr(names.rfind(' ') + 1), preset.name) << "not in alphabetical order, or twice";
    names += (names.empty() ? "" : ", ") + std::string(preset.name);
  }
  EXPECT_EQ(preset_names(), names);
  EXPECT_FALSE(find_preset("Cream"));
  EXPECT_FALSE(find_preset(""));
}

TEST(Preset, HoldsTheReportedNumbers) {
  const double expected[3][6] = {{77.7, 1.09e5, 290.0, 31.9, 27.2, 0.22},
                                 {1000.0, 1.09e5, 1.12e4, 0.1, 10.0, 2.8},
                                 {275.0, 1.09e5, 1600.0, 120.0, 5.0, 0.27}};
  const char* names[3] = {"cream", "oobleck", "pie"};
  for (int i = 0; i < 3; ++i)
    for (int e = 0; e < 6; ++e)
      EXPECT_EQ(std::get<HerschelBulkley>(find_preset(names[i])->material).parameters.*entries[e].member, expected[i][e]);
}

TEST(Preset, ThoseInTheRheometersConventionAreConverted) {
  const auto paint = std::get<HerschelBulkley>(find_preset("carbopol")->material).parameters;
  EXPECT_NEAR(paint.sigma_Y, 89.0 * std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(paint.eta, 47.7 * std::pow(2.0, 0.7075), 1e-12);
  EXPECT_EQ(paint.h, 0.415);
}

TEST(Preset, SandAndSnowAreThoseOfTheirSources) {
  const auto sand = std::get<DruckerPrager>(find_preset("sand")->material).parameters;
  EXPECT_NEAR(sand.shear_modulus, 136038.4615, 1e-4);
  EXPECT_NEAR(sand.bulk_modulus - 2.0 / 3.0 * sand.shear_modulus, 204057.6923, 1e-4);
  const auto snow = std::get<Snow>(find_preset("snow")->material).parameters;
  EXPECT_NEAR(snow.shear_modulus, 1.4e5 / 2.4, 1e-9);
  EXPECT_EQ(snow.critical_compression, 2.5e-2);
  EXPECT_EQ(snow.critical_stretch, 7.5e-3);
  EXPECT_EQ(snow.hardening, 10.0);
}

TEST(Preset, MagneticFluidsHaveTheNumbersOfCarlsonsFits) {
  struct Row {
    const char* name;
    double saturation, susceptibility, yield_50, yield_200;  // A/m, 1, Pa at 50 and 200 kA/m beyond that without a field
    double tolerance;
  };
  for (const Row& row : {Row{"mrf_132dg", 417983.0, 5.762, 14662.0, 40812.0, 1e-4},
                         Row{"ferro_oobleck", 51022.0, 0.703, 0.4 * 866.0, 0.4 * 2411.0, 1e-3}}) {
    const auto preset = find_preset(row.name);
    ASSERT_TRUE(preset && preset->magnetisation);
    EXPECT_NEAR(preset->magnetisation->saturation, row.saturation, row.tolerance * row.saturation);
    EXPECT_NEAR(preset->magnetisation->susceptibility, row.susceptibility, row.tolerance * row.susceptibility);
    EXPECT_NEAR(field_yield(preset->material).at(5e4), row.yield_50, row.tolerance * row.yield_50);
    EXPECT_NEAR(field_yield(preset->material).at(2e5), row.yield_200, row.tolerance * row.yield_200);
  }
  // Elastic strain at yield stays small in any field.
  for (const Preset& preset : presets()) {
    if (!field_yield(preset.material).given()) continue;
    const auto p = std::get<HerschelBulkley>(preset.material).parameters;
    EXPECT_GE(p.shear_modulus, 9.9 * p.field_yield.saturation) << preset.name;
  }
  EXPECT_NEAR(find_preset("emg_700")->magnetisation->at(1e12), 28250.0, 1e-3);
  EXPECT_FALSE(find_preset("cream")->magnetisation);
}

// Who uses numbers that are not published is told so.
TEST(Preset, CaveatsOfUncertainAndProposedNumbersOnly) {
  for (const Preset& preset : presets()) {
    const bool sure = preset.confidence == Confidence::published || preset.confidence == Confidence::measured;
    const std::string text = caveat(preset);
    EXPECT_EQ(text.empty(), sure) << preset.name;
    if (sure) continue;
    for (const std::string_view part : {preset.name, std::string_view(name(preset.confidence)), preset.source})
      EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace bulkley::parameters_test
