#include "material/laws/neo_hookean.hpp"

#include "material/laws/shared_keys.hpp"

namespace bulkley {

NeoHookean::Parameters from_youngs_modulus(double density, double youngs_modulus, double poisson_ratio) {
  return {density, youngs_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio)), youngs_modulus / (2.0 * (1.0 + poisson_ratio))};
}

template <>
struct LawKeys<NeoHookean> : SolidKeys<NeoHookean> {
  static const config::Keys<Input>& table() {
    static const auto keys = solid_keys("An elastic solid for large deformations.");
    return keys;
  }
};

template struct LawText<NeoHookean>;

}  // namespace bulkley
