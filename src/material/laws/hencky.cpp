#include "material/laws/hencky.hpp"

#include "material/laws/shared_keys.hpp"

namespace bulkley {

template <>
struct LawKeys<Hencky> : SolidKeys<Hencky> {
  static const config::Keys<Input>& table() {
    static const auto keys = solid_keys(
        "An elastic solid that is linear in the logarithmic strain (St. Venant-Kirchhoff-Hencky): good in strong "
        "compression.");
    return keys;
  }
};

template struct LawText<Hencky>;

}  // namespace bulkley
