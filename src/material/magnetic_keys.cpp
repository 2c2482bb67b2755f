#include "material/magnetic_keys.hpp"

namespace bulkley {

config::Names<Magnetisation::Law> names(config::Of<Magnetisation::Law>) {
  using Law = Magnetisation::Law;
  return {{"linear", Law::linear},
          {"langevin", Law::langevin},
          {"froehlich_kennelly", Law::froehlich_kennelly},
          {"exponential", Law::exponential}};
}

config::Names<FieldYield::Form> names(config::Of<FieldYield::Form>) {
  using Form = FieldYield::Form;
  return {{"none", Form::none}, {"tanh", Form::tanh}, {"power", Form::power}};
}

const config::Keys<MagneticProperties>& keys(config::Of<MagneticProperties>) {
  const auto saturates = [](const MagneticProperties& m) { return m.magnetisation.law != Magnetisation::Law::linear; };
  const auto yields = [](const MagneticProperties& m) { return m.yield.given(); };
  static const auto table =
      config::Keys<MagneticProperties>(
          "How a magnetic field H acts on the material; a run needs [magnetics]. With x = susceptibility H/saturation, M is "
          "susceptibility H (linear), saturation "
          "(coth 3x - 1/(3x)) (langevin), saturation x/(1 + x) (froehlich_kennelly) or saturation (1 - exp(-x)) "
          "(exponential).")
          .key("law", [](auto& m) -> auto& { return m.magnetisation.law; },
               {.about = "Magnetisation law.", .required = true})
          .key("susceptibility", [](auto& m) -> auto& { return m.magnetisation.susceptibility; },
               {.about = "dM/dH at H = 0.", .range = config::above(0.0), .required = true})
          .key("saturation", [](auto& m) -> auto& { return m.magnetisation.saturation; },
               {.about = "Largest magnetisation.",
                .unit = "A/m",
                .range = config::above(0.0),
                .required = true,
                .may_be_infinite = true})
          .only_with("a law that saturates", saturates)
          .key("yield", [](auto& m) -> auto& { return m.yield.form; },
               {.about = "What the field adds to the yield stress of a Herschel-Bulkley fluid, thixotropic or not. tanh: "
                         "yield_saturation tanh(H/yield_field); power: yield_saturation min(1, (H/yield_field)^1.5). It is "
                         "isotropic, which real fluids are not."})
          .key("yield_saturation", [](auto& m) -> auto& { return m.yield.saturation; },
               {.about = "Largest addition to the yield stress, as a shear rheometer reports it.",
                .unit = "Pa",
                .range = config::at_least(0.0),
                .required = true})
          .only_with("yield = \"tanh\" or \"power\"", yields)
          .key("yield_field", [](auto& m) -> auto& { return m.yield.field; },
               {.about = "Field strength of that law.", .unit = "A/m", .range = config::above(0.0), .required = true})
          .only_with("yield = \"tanh\" or \"power\"", yields);
  return table;
}

}  // namespace bulkley
