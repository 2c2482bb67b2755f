#include "material/laws/toy_law.hpp"

#include "material/laws/shared_keys.hpp"

namespace bulkley {

template <>
struct LawKeys<ToyLaw> : PlainKeys<ToyLaw> {
  static const config::Keys<Input>& table() {
    using P = ToyLaw::Parameters;
    static const auto keys = config::Keys<P>("A toy.")
                                 .key("density", &P::density, density_rule())
                                 .key("bulk_modulus", &P::bulk_modulus, bulk_modulus_rule())
                                 .key("shear_modulus", &P::shear_modulus, shear_modulus_rule());
    return keys;
  }
};

template struct LawText<ToyLaw>;

}  // namespace bulkley
