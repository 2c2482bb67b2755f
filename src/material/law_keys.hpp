#pragma once
// How the laws' keys are read into their parameters.

#include <cmath>
#include <vector>

#include "config/groups.hpp"
#include "material/laws/herschel_bulkley_keys.hpp"
#include "material/material_keys.hpp"

namespace bulkley {

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
  static config::Value write(const Law& law) {
    return LawKeys<Law>::table().write(
        {{law.parameters.bulk_modulus, law.parameters.shear_modulus, {}, {}}, law.parameters});
  }

 protected:
  /// The keys of density and stiffness.
  static config::Keys<Input> solid_keys(const std::string& about) {
    const std::string either = "required in one of the pairs";
    config::Keys<Input> keys(about +
                             " The stiffness is given by `bulk_modulus` and `shear_modulus`, or by `youngs_modulus` and "
                             "`poisson_ratio`; never mixed.");
    keys.key("density", [](auto& s) -> auto& { return s.parameters.density; },
             {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = "**required**"})
        .key("bulk_modulus", &Input::bulk_modulus,
             {.about = "Resistance to a change of volume.",
              .unit = "Pa",
              .range = config::above(0.0),
              .default_text = either})
        .key("shear_modulus", &Input::shear_modulus,
             {.about = "Resistance to shear.", .unit = "Pa", .range = config::at_least(0.0), .default_text = either})
        .key("youngs_modulus", &Input::youngs_modulus,
             {.about = "Stiffness in tension.", .unit = "Pa", .range = config::above(0.0), .default_text = either})
        .key("poisson_ratio", &Input::poisson_ratio,
             {.about = "Lateral contraction over extension.",
              .range = config::strictly_between(-1.0, 0.5),
              .default_text = either});
    return keys;
  }
};

#define BULKLEY_LAW_KEYS(Law, Base)            \
  template <>                                  \
  struct LawKeys<Law> : Base<Law> {            \
    static const config::Keys<Input>& table(); \
  }
BULKLEY_LAW_KEYS(NeoHookean, SolidKeys);
BULKLEY_LAW_KEYS(Hencky, SolidKeys);
BULKLEY_LAW_KEYS(FixedCorotated, SolidKeys);
BULKLEY_LAW_KEYS(DruckerPrager, SolidKeys);
BULKLEY_LAW_KEYS(Snow, SolidKeys);
BULKLEY_LAW_KEYS(Newtonian, PlainKeys);
BULKLEY_LAW_KEYS(OldroydB, PlainKeys);
#undef BULKLEY_LAW_KEYS

template <>
struct LawKeys<FiniteViscoelastic> : SolidKeys<FiniteViscoelastic> {
  static const config::Keys<Input>& table();
  /// Without a bulk relaxation time that is infinite: scenes hold finite numbers only.
  static config::Value write(const FiniteViscoelastic& law) {
    config::Value value = SolidKeys::write(law);
    if (std::isinf(law.parameters.bulk_relaxation_time))
      std::erase_if(value.items, [](const config::Value& entry) { return entry.key == "bulk_relaxation_time"; });
    return value;
  }
};

/// The flow keys of Herschel-Bulkley for the full structure, and those of the structure.
template <>
struct LawKeys<ThixotropicHerschelBulkley> {
  struct Input : HerschelBulkleyInput {
    ThixotropicHerschelBulkley::Parameters parameters;
  };
  static Input start(const ThixotropicHerschelBulkley& law) { return {{}, law.parameters}; }
  static const config::Keys<Input>& table();
  static void fill(const config::Value& table, const Input& input, ThixotropicHerschelBulkley& law, config::Faults& faults);
  static config::Value write(const ThixotropicHerschelBulkley& law);
};

}  // namespace bulkley
