#pragma once
// Keys that several laws share: density and stiffness, the two ways to give the stiffness of a solid, and the two conventions for
// the flow of a Herschel-Bulkley fluid.

#include "bulkley/material/plain_keys.hpp"
#include "material/law_text.hpp"
#include "material/laws/herschel_bulkley.hpp"

namespace bulkley {

/// What the reference page shows as the default of a key without one.
inline constexpr const char* required_key = "**required**";

inline config::Rule density_rule(const std::string& default_text = required_key) {
  return {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = default_text};
}
inline config::Rule bulk_modulus_rule(const std::string& default_text = required_key,
                                      const std::string& about = "Resistance to a change of volume.") {
  return {.about = about, .unit = "Pa", .range = config::above(0.0), .default_text = default_text};
}
inline config::Rule shear_modulus_rule(const std::string& default_text = required_key,
                                       const std::string& about = "Resistance to shear.",
                                       const config::Range& range = config::at_least(0.0)) {
  return {.about = about, .unit = "Pa", .range = range, .default_text = default_text};
}

// --- solids --------------------------------------------------------------------------------------------------------------

/// The stiffness of a solid as bulk and shear modulus, or as Young's modulus and Poisson's ratio, never mixed.
struct Stiffness {
  std::optional<double> bulk_modulus, shear_modulus, youngs_modulus, poisson_ratio;
};

/// Puts a stiffness into the parameters. False after a fault. Not collective.
bool fill_stiffness(const config::Value& table, const Stiffness& input, NeoHookean::Parameters& parameters,
                    config::Faults& faults);

/// A law whose keys are its parameters, with both ways to give the stiffness.
template <class Law>
struct SolidKeys {
  struct Input : Stiffness {
    typename Law::Parameters parameters;
  };
  static Input start(const Law& law) { return {{}, law.parameters}; }
  static void fill(const config::Value& table, const Input& input, Law& law, config::Faults& faults) {
    law = Law{input.parameters};
    if (fill_stiffness(table, input, law.parameters, faults)) report_numbers_not_given(table, write(law), faults);
  }
  static Input input(const Law& law) {
    return {{law.parameters.bulk_modulus, law.parameters.shear_modulus, {}, {}}, law.parameters};
  }
  static config::Value write(const Law& law) { return LawKeys<Law>::table().write(input(law)); }

 protected:
  /// The keys of density and stiffness.
  static config::Keys<Input> solid_keys(const std::string& about) {
    const std::string either = "required in one of the pairs";
    config::Keys<Input> keys(about +
                             " The stiffness is given by `bulk_modulus` and `shear_modulus`, or by `youngs_modulus` and "
                             "`poisson_ratio`; never mixed.");
    keys.key(
            "density", [](auto& s) -> auto& { return s.parameters.density; }, density_rule())
        .key("bulk_modulus", &Input::bulk_modulus, bulk_modulus_rule(either))
        .key("shear_modulus", &Input::shear_modulus, shear_modulus_rule(either))
        .key("youngs_modulus", &Input::youngs_modulus,
             {.about = "Stiffness in tension.", .unit = "Pa", .range = config::above(0.0), .default_text = either})
        .key("poisson_ratio", &Input::poisson_ratio,
             {.about = "Lateral contraction over extension.",
              .range = config::strictly_between(-1.0, 0.5),
              .default_text = either});
    return keys;
  }
};

// --- Herschel-Bulkley fluids ---------------------------------------------------------------------------------------------

/// The flow parameters are in one of two conventions, never mixed (docs/theory.md, "Herschel-Bulkley").
struct HerschelBulkleyInput {
  std::optional<double> density, bulk_modulus, shear_modulus;
  std::optional<double> yield_stress, consistency, flow_index;  ///< shear rheometer: tau = tau_y + K shear_rate^n
  std::optional<double> sigma_Y, eta, h;                        ///< Yue et al. 2015
  std::optional<double> background_viscosity;
};

/// What gives the parameters again, bit for bit: in the convention of the scene they are from, else in Yue's. Not collective.
HerschelBulkleyInput flow_input(const HerschelBulkley::Parameters& parameters);

/// Puts the input into parameters that hold a preset's values or NaN. Faults on what is missing or contradictory. Not collective.
void fill_flow(const config::Value& table, const HerschelBulkleyInput& input, HerschelBulkley::Parameters& parameters,
               config::Faults& faults);

/// The flow in the convention that flow_input does not use, as a comment. Not collective.
std::string flow_comment(const HerschelBulkley::Parameters& parameters);

/// Adds the keys of HerschelBulkleyInput to those of an input that is derived from it. Not collective.
template <class Input>
void add_flow_keys(config::Keys<Input>& keys) {
  constexpr auto flow_range = config::between(0.1, 3.0);
  const std::string elsewhere = "from `preset`, else required";
  const std::string either = "from `preset`, else required in one convention";
  keys.key("density", &HerschelBulkleyInput::density, density_rule(elsewhere))
      .key("bulk_modulus", &HerschelBulkleyInput::bulk_modulus, bulk_modulus_rule(elsewhere))
      .key("shear_modulus", &HerschelBulkleyInput::shear_modulus,
           shear_modulus_rule(elsewhere, "Elastic resistance to shear."))
      .key("yield_stress", &HerschelBulkleyInput::yield_stress,
           {.about = "Shear stress at which the fluid begins to flow: tau = yield_stress + consistency * "
                     "shear_rate^flow_index.",
            .unit = "Pa",
            .range = config::at_least(0.0),
            .default_text = either})
      .key("consistency", &HerschelBulkleyInput::consistency,
           {.about = "Factor of the shear rate's power.",
            .unit = "Pa s^n",
            .range = config::at_least(0.0),
            .default_text = either})
      .key("flow_index", &HerschelBulkleyInput::flow_index,
           {.about = "Power n of the shear rate; below 1 the fluid thins with the rate, above it thickens.",
            .unit = "",
            .range = flow_range,
            .default_text = either})
      .key("sigma_Y", &HerschelBulkleyInput::sigma_Y,
           {.about = "Yield stress in uniaxial (von Mises) terms.",
            .unit = "Pa",
            .range = config::at_least(0.0),
            .default_text = either})
      .key("eta", &HerschelBulkleyInput::eta,
           {.about = "Viscosity of Yue's flow rule; 0: perfectly plastic.",
            .unit = "Pa s^h",
            .range = config::at_least(0.0),
            .may_be_infinite = true,
            .default_text = either})
      .key("h", &HerschelBulkleyInput::h,
           {.about = "Power of Yue's flow rule, the same as flow_index.", .range = flow_range, .default_text = either})
      .key("background_viscosity", &HerschelBulkleyInput::background_viscosity,
           {.about = "Dynamic viscosity of a Newtonian stress in addition to the flow's; no effect if 0.",
            .unit = "Pa s",
            .range = config::at_least(0.0),
            .default_text = "from `preset`, else 0"});
}

// --- what laws/<law>.cpp instantiates --------------------------------------------------------------------------------------

template <class Law>
bool LawText<Law>::read(const config::Value& table, Law& law, config::Faults& faults) {
  return read_law(table, law, faults);
}
template <class Law>
config::Value LawText<Law>::write(const Law& law) {
  return LawKeys<Law>::write(law);
}
template <class Law>
void LawText<Law>::describe(const std::string& title, const std::string& path, std::vector<config::TableText>& out) {
  LawKeys<Law>::table().describe(title, path, out);
}
template <class Law>
std::optional<std::string> LawText<Law>::fault(const Law& law) {
  return law_fault(law);
}

}  // namespace bulkley
