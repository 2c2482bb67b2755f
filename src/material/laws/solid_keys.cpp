#include <fmt/format.h>

#include <cmath>

#include "material/law_keys.hpp"

namespace bulkley {

void report_numbers_not_given(const config::Value& table, const config::Value& written, config::Faults& faults) {
  for (const config::Value& entry : written.items)
    if (entry.kind == config::Kind::number && std::isnan(entry.number))
      config::report_missing_key(table, entry.key, false, faults);
}

bool fill_stiffness(const config::Value& table, const Stiffness& input, NeoHookean::Parameters& p, config::Faults& faults) {
  const std::vector<std::string> moduli{"bulk_modulus", "shear_modulus"}, engineering{"youngs_modulus", "poisson_ratio"};
  if (config::refuse_mixture(table, moduli, "one pair", engineering, "the other pair", faults)) return false;
  if (config::first_given(table, engineering)) {
    for (const std::string& name : engineering)
      if (!table.find(name)) {
        config::report_missing_key(table, name, false, faults);
        return false;
      }
    p = from_youngs_modulus(p.density, *input.youngs_modulus, *input.poisson_ratio);
    return true;
  }
  if (std::isnan(p.bulk_modulus) && !config::first_given(table, moduli)) {
    faults.add(table.place,
               fmt::format("{} needs 'bulk_modulus' and 'shear_modulus', or 'youngs_modulus' and 'poisson_ratio'",
                           config::table_name(table.path)));
    return false;
  }
  if (input.bulk_modulus) p.bulk_modulus = *input.bulk_modulus;
  if (input.shear_modulus) p.shear_modulus = *input.shear_modulus;
  return true;
}

const config::Keys<LawKeys<NeoHookean>::Input>& LawKeys<NeoHookean>::table() {
  static const auto keys = solid_keys("An elastic solid for large deformations.");
  return keys;
}

const config::Keys<LawKeys<Hencky>::Input>& LawKeys<Hencky>::table() {
  static const auto keys = solid_keys(
      "An elastic solid that is linear in the logarithmic strain (St. Venant-Kirchhoff-Hencky): good in strong "
      "compression.");
  return keys;
}

const config::Keys<LawKeys<FixedCorotated>::Input>& LawKeys<FixedCorotated>::table() {
  static const auto keys = solid_keys("An elastic solid that is linear in the stretch: withstands being turned inside out.");
  return keys;
}

const config::Keys<LawKeys<FiniteViscoelastic>::Input>& LawKeys<FiniteViscoelastic>::table() {
  static const auto keys =
      solid_keys(
          "A viscoelastic solid of two branches: a neo-Hookean one, and one in logarithmic strain whose stress relaxes.")
          .key("branch_shear_modulus", [](auto& s) -> auto& { return s.parameters.branch_shear_modulus; },
               {.about = "Resistance of the relaxing branch to shear.",
                .unit = "Pa",
                .range = config::above(0.0),
                .default_text = "**required**"})
          .key("branch_bulk_modulus", [](auto& s) -> auto& { return s.parameters.branch_bulk_modulus; },
               {.about = "Resistance of the relaxing branch to a change of volume.",
                .unit = "Pa",
                .range = config::at_least(0.0)})
          .key("relaxation_time", [](auto& s) -> auto& { return s.parameters.relaxation_time; },
               {.about = "Time in which the branch's shear stress falls to 1/e.",
                .unit = "s",
                .range = config::above(0.0),
                .default_text = "**required**"})
          .key("bulk_relaxation_time", [](auto& s) -> auto& { return s.parameters.bulk_relaxation_time; },
               {.about = "The same for the branch's pressure; infinite: it does not relax.",
                .unit = "s",
                .range = config::above(0.0)});
  return keys;
}

const config::Keys<LawKeys<DruckerPrager>::Input>& LawKeys<DruckerPrager>::table() {
  static const auto keys =
      solid_keys("Sand and other dry grains: elastic in compression, sliding by friction, without resistance to tension.")
          .key("friction_angle", [](auto& s) -> auto& { return s.parameters.friction_angle; },
               {.about = "Angle of internal friction.",
                .unit = "degrees",
                .range = config::above_to(0.0, 60.0),
                .default_text = "**required**"})
          .key(
              "cohesion", [](auto& s) -> auto& { return s.parameters.cohesion; },
              {.about = "Shear stress that the grains hold without pressure.", .unit = "Pa", .range = config::at_least(0.0)})
          .key("hardening_rise", [](auto& s) -> auto& { return s.parameters.hardening_rise; },
               {.about = "Rise of the friction angle at first, per unit of plastic strain.",
                .unit = "degrees",
                .range = config::at_least(0.0)})
          .key("hardening_decay", [](auto& s) -> auto& { return s.parameters.hardening_decay; },
               {.about = "How soon the change of the friction angle fades: exp(-hardening_decay q), q the plastic strain.",
                .range = config::at_least(0.0)})
          .key("hardening_drop", [](auto& s) -> auto& { return s.parameters.hardening_drop; },
               {.about = "By how much the friction angle is smaller before any plastic strain.",
                .unit = "degrees",
                .range = config::at_least(0.0)});
  return keys;
}

const config::Keys<LawKeys<Snow>::Input>& LawKeys<Snow>::table() {
  static const auto keys =
      solid_keys("Snow: yields beyond a critical stretch, hardens when packed, softens when torn (Stomakhin et al. 2013).")
          .key("critical_compression", [](auto& s) -> auto& { return s.parameters.critical_compression; },
               {.about = "Compression at which it yields: the smallest elastic stretch is 1 less this.",
                .range = config::strictly_between(0.0, 1.0),
                .default_text = "**required**"})
          .key("critical_stretch", [](auto& s) -> auto& { return s.parameters.critical_stretch; },
               {.about = "Extension at which it yields: the largest elastic stretch is 1 more than this.",
                .range = config::above(0.0),
                .default_text = "**required**"})
          .key("hardening", [](auto& s) -> auto& { return s.parameters.hardening; },
               {.about = "Exponent xi of the moduli's factor exp(xi (1 - J_p)), J_p the plastic volume ratio.",
                .range = config::at_least(0.0),
                .default_text = "**required**"});
  return keys;
}

}  // namespace bulkley
