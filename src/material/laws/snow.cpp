#include "material/laws/snow.hpp"

#include "material/laws/shared_keys.hpp"

namespace bulkley {

template <>
struct LawKeys<Snow> : SolidKeys<Snow> {
  static const config::Keys<Input>& table() {
    static const auto keys =
        solid_keys("Snow: yields beyond a critical stretch, hardens when packed, softens when torn (Stomakhin et al. 2013).")
            .key("critical_compression", [](auto& s) -> auto& { return s.parameters.critical_compression; },
                 {.about = "Compression at which it yields: the smallest elastic stretch is 1 less this.",
                  .range = config::strictly_between(0.0, 1.0),
                  .default_text = required_key})
            .key("critical_stretch", [](auto& s) -> auto& { return s.parameters.critical_stretch; },
                 {.about = "Extension at which it yields: the largest elastic stretch is 1 more than this.",
                  .range = config::above(0.0),
                  .default_text = required_key})
            .key("hardening", [](auto& s) -> auto& { return s.parameters.hardening; },
                 {.about = "Exponent xi of the moduli's factor exp(xi (1 - J_p)), J_p the plastic volume ratio.",
                  .range = config::at_least(0.0),
                  .default_text = required_key});
    return keys;
  }
};

template struct LawText<Snow>;

}  // namespace bulkley
