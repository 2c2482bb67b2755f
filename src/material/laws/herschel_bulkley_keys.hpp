#pragma once
// Keys of [materials.NAME] with law = "herschel_bulkley".

#include "material/material_keys.hpp"

namespace bulkley {

/// The flow parameters stand in one of two conventions, never mixed (docs/theory.md, "Herschel-Bulkley").
struct HerschelBulkleyInput {
  std::optional<double> density, bulk_modulus, shear_modulus;
  std::optional<double> yield_stress, consistency, flow_index;  ///< shear rheometer: tau = tau_y + K shear_rate^n
  std::optional<double> sigma_Y, eta, h;                        ///< Yue et al. 2015
  std::optional<double> background_viscosity;
};

/// What gives the parameters again, in Yue's convention. Not collective.
HerschelBulkleyInput flow_input(const HerschelBulkley::Parameters& parameters);

/// The flow in the shear rheometer's convention, as a comment. Not collective.
std::string rheometer_comment(const HerschelBulkley::Parameters& parameters);

/// Adds the keys of HerschelBulkleyInput to those of an input that is derived from it. Not collective.
template <class Input>
void add_flow_keys(config::Keys<Input>& keys) {
  constexpr auto flow_range = config::between(0.1, 3.0);
  const std::string elsewhere = "from `preset`, else required";
  const std::string either = "from `preset`, else required in one convention";
  keys.key("density", &HerschelBulkleyInput::density,
           {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = elsewhere})
      .key("bulk_modulus", &HerschelBulkleyInput::bulk_modulus,
           {.about = "Resistance to a change of volume.",
            .unit = "Pa",
            .range = config::above(0.0),
            .default_text = elsewhere})
      .key(
          "shear_modulus", &HerschelBulkleyInput::shear_modulus,
          {.about = "Elastic resistance to shear.", .unit = "Pa", .range = config::at_least(0.0), .default_text = elsewhere})
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
            .default_text = either})
      .key("h", &HerschelBulkleyInput::h,
           {.about = "Power of Yue's flow rule, the same as flow_index.", .range = flow_range, .default_text = either})
      .key("background_viscosity", &HerschelBulkleyInput::background_viscosity,
           {.about = "Dynamic viscosity of a Newtonian stress beside the flow's; of no matter where 0.",
            .unit = "Pa s",
            .range = config::at_least(0.0),
            .default_text = "from `preset`, else 0"});
}

template <>
struct LawKeys<HerschelBulkley> {
  using Input = HerschelBulkleyInput;
  static Input start(const HerschelBulkley&) { return {}; }
  static const config::Keys<Input>& table();
  static void fill(const config::Value& table, const Input& input, HerschelBulkley& law, config::Faults& faults);
  static config::Value write(const HerschelBulkley& law);
};

}  // namespace bulkley
