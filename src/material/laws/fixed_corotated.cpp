#include "material/laws/fixed_corotated.hpp"

#include "material/laws/shared_keys.hpp"

namespace bulkley {

template <>
struct LawKeys<FixedCorotated> : SolidKeys<FixedCorotated> {
  static const config::Keys<Input>& table() {
    static const auto keys =
        solid_keys("An elastic solid that is linear in the stretch: withstands inversion (det F <= 0).");
    return keys;
  }
};

template struct LawText<FixedCorotated>;

}  // namespace bulkley
