#include "material/laws/finite_viscoelastic.hpp"

#include <cmath>

#include "material/laws/shared_keys.hpp"

namespace bulkley {

template <>
struct LawKeys<FiniteViscoelastic> : SolidKeys<FiniteViscoelastic> {
  static const config::Keys<Input>& table() {
    static const auto keys =
        solid_keys(
            "A viscoelastic solid of two branches: a neo-Hookean one, and one in logarithmic strain whose stress relaxes.")
            .key("branch_shear_modulus", [](auto& s) -> auto& { return s.parameters.branch_shear_modulus; },
                 {.about = "Resistance of the relaxing branch to shear.",
                  .unit = "Pa",
                  .range = config::above(0.0),
                  .default_text = required_key})
            .key("branch_bulk_modulus", [](auto& s) -> auto& { return s.parameters.branch_bulk_modulus; },
                 {.about = "Resistance of the relaxing branch to a change of volume.",
                  .unit = "Pa",
                  .range = config::at_least(0.0)})
            .key("relaxation_time", [](auto& s) -> auto& { return s.parameters.relaxation_time; },
                 {.about = "Time in which the branch's shear stress falls to 1/e.",
                  .unit = "s",
                  .range = config::above(0.0),
                  .default_text = required_key})
            .key("bulk_relaxation_time", [](auto& s) -> auto& { return s.parameters.bulk_relaxation_time; },
                 {.about = "The same for the branch's pressure; infinite: it does not relax.",
                  .unit = "s",
                  .range = config::above(0.0),
                  .may_be_infinite = true});
    return keys;
  }
  /// Without a bulk relaxation time that is infinite: scenes hold finite numbers only.
  static config::Value write(const FiniteViscoelastic& law) {
    config::Value value = SolidKeys::write(law);
    if (std::isinf(law.parameters.bulk_relaxation_time))
      std::erase_if(value.items, [](const config::Value& entry) { return entry.key == "bulk_relaxation_time"; });
    return value;
  }
};

template struct LawText<FiniteViscoelastic>;

}  // namespace bulkley
