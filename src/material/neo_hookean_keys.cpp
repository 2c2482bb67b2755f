#include "bulkley/material/neo_hookean_keys.hpp"

#include <fmt/format.h>

#include <cmath>

#include "bulkley/config/groups.hpp"

namespace bulkley {

const config::Keys<NeoHookeanInput>& LawKeys<NeoHookean>::table() {
  using Input = NeoHookeanInput;
  const std::string either = "required in one of the pairs";
  static const auto keys =
      config::Keys<Input>(
          "An elastic solid for large deformations. The stiffness is given by `bulk_modulus` and `shear_modulus`, or by "
          "`youngs_modulus` and `poisson_ratio`; never mixed.")
          .key("density", &Input::density,
               {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .required = true})
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

void LawKeys<NeoHookean>::fill(const config::Value& table, const Input& input, NeoHookean& law, config::Faults& faults) {
  const std::vector<std::string> moduli{"bulk_modulus", "shear_modulus"}, engineering{"youngs_modulus", "poisson_ratio"};
  if (config::refuse_mixture(table, moduli, "one pair", engineering, "the other pair", faults)) return;
  const bool by_youngs_modulus = config::first_given(table, engineering) != nullptr;
  if (!by_youngs_modulus && !config::first_given(table, moduli)) {
    faults.add(table.place,
               fmt::format("{} needs 'bulk_modulus' and 'shear_modulus', or 'youngs_modulus' and 'poisson_ratio'",
                           config::table_name(table.path)));
    return;
  }
  for (const std::string& name : by_youngs_modulus ? engineering : moduli)
    if (!table.find(name)) {
      config::report_missing_key(table, name, false, faults);
      return;
    }
  law.parameters = by_youngs_modulus ? from_youngs_modulus(*input.density, *input.youngs_modulus, *input.poisson_ratio)
                                     : NeoHookean::Parameters{*input.density, *input.bulk_modulus, *input.shear_modulus};
}

config::Value LawKeys<NeoHookean>::write(const NeoHookean& law) {
  Input input;
  input.density = law.parameters.density;
  input.bulk_modulus = law.parameters.bulk_modulus;
  input.shear_modulus = law.parameters.shear_modulus;
  return table().write(input);
}

}  // namespace bulkley
