#include "material/preset.hpp"

#include <fmt/format.h>

#include <cmath>

#include "bulkley/config/toml.hpp"
#include "material/material_keys.hpp"

namespace bulkley {

namespace {

// Density, bulk modulus and shear modulus; then the flow in the convention of its source.
struct Elastic {
  double density, bulk_modulus, shear_modulus;
};
Material yue(Elastic e, double sigma_Y, double eta, double h) {
  return HerschelBulkley{{e.density, e.bulk_modulus, e.shear_modulus, sigma_Y, eta, h}};
}
Material rheometer(Elastic e, double yield_stress, double consistency, double flow_index) {
  HerschelBulkley::Parameters p{e.density, e.bulk_modulus, e.shear_modulus};
  set_flow(p, {yield_stress, consistency, flow_index});
  return HerschelBulkley{p};
}
Material klar_sand() {
  DruckerPrager::Parameters p{from_youngs_modulus(2200.0, 3.537e5, 0.3)};
  p.friction_angle = 35.0;
  p.hardening_decay = 0.2;
  p.hardening_drop = 10.0;
  return DruckerPrager{p};
}

// A suspension of iron with the volume fraction `iron`: magnetisation and yield stress by Carlson's fits, the latter times
// `factor`.
Material with_iron(Material fluid, double iron, double factor) {
  return with_field_yield(fluid, {FieldYield::Form::tanh, factor * 271700.0 * std::pow(iron, 1.5239), 1.0 / 6.33e-6});
}
Magnetisation iron_suspension(double iron) {
  const double polarisation = 1.91 * std::pow(iron, 1.133);  // T
  return {Magnetisation::Law::exponential, 10.97 * polarisation, polarisation / vacuum_permeability};
}
Material stomakhin_snow() { return Snow{{from_youngs_modulus(400.0, 1.4e5, 0.2), 2.5e-2, 7.5e-3, 10.0}}; }

#define BULKLEY_SOFT                                                                                                      \
  "bulk modulus lowered from 2e9 Pa, which no explicit time step affords, to 2e5 Pa: below 1 % of compression up to 1.3 " \
  "m/s"
#define BULKLEY_FITTED                                                                                                \
  "flow curve at 23 C (0.1 to 100 1/s) of the ViRheometry project (Hamamichi et al. 2023), fitted by relative least " \
  "squares"
#define BULKLEY_SAUCE "; moduli chosen here"
#define BULKLEY_OPTIMUM \
  "first optimum of a dam-break identification shipped with ViRheometry (Hamamichi et al. 2023), not its final value"
#define BULKLEY_CREAMY "scene file of the creamystrand code (Fei et al. 2019)"
#define BULKLEY_CARLSON                                                                                                  \
  "magnetisation and yield stress by Carlson's fits for suspensions of iron, quoted second hand; isotropic yield is an " \
  "approximation: real ones yield highest across the field; no surface tension"
#define BULKLEY_REPORT "material file behind Bhargava's report on MPM for non-Newtonian fluids (IST Austria)"

}  // namespace

// Where a source gives no density, that of water is taken.
std::span<const Preset> presets() {
  using enum Confidence;
  constexpr double soft = 2e5;  // Pa
  constexpr Elastic sauce{1000.0, 1e5, 1e3};
  // clang-format off
  static const Preset table[] = {
      {"bouncing_oobleck", yue({1200.0, 1e6, 1e5}, 0.1, 90.0, 2.8), proposed,
       "designed here such that stress relaxes more slowly than a ball of 0.1 m at 3 m/s rebounds (docs/materials/herschel_bulkley.md)"},
      {"carbopol", rheometer({1000.0, 1e5, 5e3}, 89.0, 47.7, 0.415), uncertain,
       "Carbopol Ultrez 10 at 0.30 %, Cochard & Ancey 2009, quoted from memory; moduli chosen here"},
      {"chocolate_sauce", rheometer(sauce, 3.2, 11.3, 0.70), measured, BULKLEY_FITTED BULKLEY_SAUCE},
      {"chuno_sauce", rheometer(sauce, 0.79, 1.85, 0.512), measured, BULKLEY_FITTED BULKLEY_SAUCE},
      {"cobb_dressing", rheometer({1025.0, 1e5, 1e3}, 12.89, 9.82, 0.705), uncertain, BULKLEY_OPTIMUM BULKLEY_SAUCE},
      {"coleslaw_dressing", rheometer(sauce, 2.84, 4.78, 0.336), measured, BULKLEY_FITTED BULKLEY_SAUCE},
      {"congee", rheometer(sauce, 0.15, 10.62, 0.984), uncertain, BULKLEY_OPTIMUM BULKLEY_SAUCE},
      {"cream", yue({77.7, 1.09e5, 290.0}, 31.9, 27.2, 0.22), published, BULKLEY_REPORT ", figure 7"},
      {"dip", yue({935.0, 1e5, 1e4}, 70.8, 30.5, 0.44), published,
       "assets of the AGTaichiMPM code: an unnamed dip like mayonnaise; density the middle of its 910 to 960 kg/m^3"},
      {"emg_700", Newtonian{{1290.0, soft, 5e-3}}, uncertain,
       "water-based ferrofluid: density and saturation as public scripts quote the maker, susceptibility near 1 and viscosity below 5 mPa s from memory; no surface tension; " BULKLEY_SOFT,
       Magnetisation{Magnetisation::Law::langevin, 1.0, 28250.0}},
      {"ferro_oobleck", with_iron(yue({1580.0, 1.09e5, 1.12e4}, 0.1, 10.0, 2.8), 0.05, 0.4), proposed,
       "a designed material, never measured: oobleck with 5 % of iron by volume; 0.4 of Carlson's yield stress, so that the shear modulus stays ten times it; " BULKLEY_CARLSON,
       iron_suspension(0.05)},
      {"grease", rheometer({910.0, 1e6, 5e4}, 650.0, 20.6, 0.605), uncertain,
       "flow curve quoted in a discussion of the DualSPHysics project; moduli chosen here"},
      {"ketchup", yue({1100.0, 2e5, 2e3}, 35.0, 14.0, 0.40), proposed,
       "within the ranges of rheology textbooks (yield stress 10 to 50 Pa, consistency 5 to 20, index 0.3 to 0.5)"},
      {"mayonnaise", yue({1200.0, soft, 1e3}, 7.54, 44.72, 0.316), published, BULKLEY_CREAMY "; " BULKLEY_SOFT},
      {"melted_chocolate", yue({1270.0, soft, 500.0}, 30.0, 2.8, 0.98), published,
       BULKLEY_CREAMY "; bulk modulus lowered from 1.35e8 Pa to 2e5 Pa"},
      {"moisturising_milk", rheometer({1025.0, 1e5, 1e3}, 6.14, 8.90, 0.371), measured, BULKLEY_FITTED BULKLEY_SAUCE},
      {"mrf_132dg", with_iron(rheometer({3050.0, 5e6, 5e5}, 15.0, 0.112, 1.0), 0.32, 1.0), uncertain,
       "magnetorheological fluid, 32 % of iron by volume: density and viscosity at 40 C of a public parts catalogue; yield stress without a field from memory; moduli chosen here; -5 to 17 % from the maker's yield stress between 18 and 80 kA/m; " BULKLEY_CARLSON,
       iron_suspension(0.32)},
      {"mrf_140cg", with_iron(rheometer({3640.0, 5e6, 7e5}, 15.0, 0.280, 1.0), 0.40, 1.0), uncertain,
       "magnetorheological fluid, 40 % of iron by volume: density, viscosity at 40 C and yield stress without a field from memory; moduli chosen here; 20 to 32 % below the maker's yield stress between 12 and 51 kA/m; " BULKLEY_CARLSON,
       iron_suspension(0.40)},
      {"mud", yue({1220.0, soft, 100.0}, 3.06, 0.1259, 0.8175), published, BULKLEY_CREAMY "; " BULKLEY_SOFT},
      {"mustard", rheometer(sauce, 0.004, 6.40, 0.981), uncertain, BULKLEY_OPTIMUM BULKLEY_SAUCE},
      {"oil_paint", yue({950.0, soft, 401.0}, 0.96, 17.356, 0.3162), published, BULKLEY_CREAMY "; " BULKLEY_SOFT},
      {"okonomiyaki_sauce", rheometer({1175.0, 1.2e5, 1e3}, 5.40, 7.63, 0.455), measured, BULKLEY_FITTED BULKLEY_SAUCE},
      {"oobleck", yue({1000.0, 1.09e5, 1.12e4}, 0.1, 10.0, 2.8), published, BULKLEY_REPORT ", figures 1, 6, 8 and 9"},
      {"oyster_sauce", yue({1220.0, soft, 400.0}, 2.65, 1.61, 0.62), published, BULKLEY_CREAMY "; " BULKLEY_SOFT},
      {"pie", yue({275.0, 1.09e5, 1600.0}, 120.0, 5.0, 0.27), published, BULKLEY_REPORT ", figures 5 and 8"},
      {"pomodoro_sauce", rheometer(sauce, 1.33, 15.57, 0.300), uncertain, BULKLEY_OPTIMUM BULKLEY_SAUCE},
      {"sand", klar_sand(), uncertain,
       "Klar et al. 2016: stiffness as in public codes; density and hardening (fully hardened at once) quoted from memory"},
      {"sesame_sauce", rheometer(sauce, 0.89, 0.920, 0.848), uncertain, BULKLEY_OPTIMUM BULKLEY_SAUCE},
      {"shaving_foam", yue({200.0, 1.09e5, 290.0}, 31.9, 27.2, 0.22), published,
       "default liquid of the creamystrand code (Fei et al. 2019), with the density of its cream scenes"},
      {"skin_lotion", rheometer(sauce, 4.13, 7.49, 0.461), measured, BULKLEY_FITTED BULKLEY_SAUCE},
      {"snow", stomakhin_snow(), published, "Stomakhin et al. 2013, table of default values"},
      {"sweet_bean_paste", rheometer({1250.0, 1.3e5, 1e3}, 20.47, 16.72, 0.682), uncertain, BULKLEY_OPTIMUM BULKLEY_SAUCE},
      {"tonkatsu_sauce", rheometer(sauce, 2.35, 4.68, 0.458), measured, BULKLEY_FITTED BULKLEY_SAUCE},
      {"toothpaste", yue({1300.0, 1e6, 2e4}, 300.0, 60.0, 0.35), proposed,
       "within the ranges of rheology textbooks (yield stress 100 to 300 Pa, consistency 10 to 50, index 0.2 to 0.4)"},
      {"water", Newtonian{{998.0, soft, 1.0e-3}}, published,
       "at 20 C; bulk modulus lowered from 2.2e9 Pa to 2e5 Pa: below 1 % of compression up to 1.4 m/s"},
  };
  // clang-format on
  return table;
}

std::optional<Preset> find_preset(std::string_view name) {
  for (const Preset& preset : presets())
    if (preset.name == name) return preset;
  return std::nullopt;
}

std::string preset_names() {
  std::string names;
  for (const Preset& preset : presets()) {
    if (!names.empty()) names += ", ";
    names += preset.name;
  }
  return names;
}

const char* name(Confidence confidence) {
  switch (confidence) {
    case Confidence::published:
      return "published";
    case Confidence::measured:
      return "measured";
    case Confidence::uncertain:
      return "uncertain";
    case Confidence::proposed:
      break;
  }
  return "proposed";
}

std::string caveat(const Preset& preset) {
  if (preset.confidence == Confidence::published || preset.confidence == Confidence::measured) return {};
  return fmt::format("the numbers of preset '{}' are {}: {}", preset.name, name(preset.confidence), preset.source);
}

std::string preset_reference() {
  std::string text =
      "# Presets\n\n"
      "Materials that a scene asks for by `preset = \"NAME\"`, to which keys of their law may be added that differ. SI "
      "units.\n"
      "`published`: as the source gives them; `measured`: flow curve fitted to a published measurement; `uncertain`: from "
      "memory,\n"
      "second hand, or an intermediate result of the source; `proposed`: chosen here for want of a source. A run says so "
      "when it\n"
      "uses one that is uncertain or proposed.\n\n"
      "This page is printed by `bulkley presets --markdown`; do not edit it.\n\n";
  for (const Preset& preset : presets()) {
    const config::Value material = config::Codec<std::vector<NamedMaterial>>::write(
        {{std::string(preset.name), preset.material, {}, preset.magnetisation}});
    text += fmt::format("## {}\n\n{}: {}.\n\n```toml\n", preset.name, name(preset.confidence), preset.source);
    text += config::print_toml(material) + "```\n\n";
  }
  text.pop_back();
  return text;
}

}  // namespace bulkley
