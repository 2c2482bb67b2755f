#include "material/laws/oldroyd_b.hpp"

#include "material/laws/shared_keys.hpp"

namespace bulkley {

config::Names<OldroydB::Form> names(config::Of<OldroydB::Form>) {
  return {{"upper_convected", OldroydB::Form::upper_convected}, {"isochoric", OldroydB::Form::isochoric}};
}

template <>
struct LawKeys<OldroydB> : PlainKeys<OldroydB> {
  static const config::Keys<Input>& table() {
    using P = OldroydB::Parameters;
    static const auto keys =
        config::Keys<P>("A viscoelastic fluid: a polymer whose elastic stress relaxes, in a Newtonian solvent.")
            .key("density", &P::density, density_rule())
            .key("bulk_modulus", &P::bulk_modulus, bulk_modulus_rule())
            .key("shear_modulus", &P::shear_modulus,
                 shear_modulus_rule(required_key, "Elastic modulus of the polymer; times relaxation_time, its viscosity.",
                                    config::above(0.0)))
            .key("relaxation_time", &P::relaxation_time,
                 {.about = "Time in which the polymer's stress falls to 1/e.",
                  .unit = "s",
                  .range = config::above(0.0),
                  .default_text = required_key})
            .key("solvent_viscosity", &P::solvent_viscosity,
                 {.about = "Dynamic viscosity of the solvent.", .unit = "Pa s", .range = config::at_least(0.0)})
            .key("form", &P::form,
                 {.about =
                      "upper_convected: Oldroyd's fluid; isochoric: the polymer's strain is kept at constant volume, which "
                      "limits it (Ram et al. 2015)."});
    return keys;
  }
};

template struct LawText<OldroydB>;

}  // namespace bulkley
