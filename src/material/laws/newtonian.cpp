#include "material/laws/newtonian.hpp"

#include "material/laws/shared_keys.hpp"

namespace bulkley {

template <>
struct LawKeys<Newtonian> : PlainKeys<Newtonian> {
  static const config::Keys<Input>& table() {
    using P = Newtonian::Parameters;
    static const auto keys =
        config::Keys<P>("A fluid whose stress is proportional to the rate of deformation, slightly compressible.")
            .key("density", &P::density, density_rule())
            .key("bulk_modulus", &P::bulk_modulus,
                 bulk_modulus_rule(required_key,
                                   "Resistance to a change of volume; density times the square of the speed of sound."))
            .key("viscosity", &P::viscosity,
                 {.about = "Dynamic viscosity.",
                  .unit = "Pa s",
                  .range = config::at_least(0.0),
                  .default_text = required_key})
            .key("tait_exponent", &P::tait_exponent,
                 {.about = "Exponent n of the pressure (bulk_modulus / n) (J^-n - 1); 1: linear in the density.",
                  .range = config::between(1.0, 20.0)})
            .key("tension", &P::tension,
                 {.about = "Whether stretched fluid pulls; without, drops of a splash come apart freely."});
    return keys;
  }
};

template struct LawText<Newtonian>;

}  // namespace bulkley
