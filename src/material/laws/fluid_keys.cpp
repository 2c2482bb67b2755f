#include <cmath>

#include "material/law_keys.hpp"

namespace bulkley {

namespace {
const std::string required = "**required**";
}

config::Names<OldroydB::Form> names(config::Of<OldroydB::Form>) {
  return {{"upper_convected", OldroydB::Form::upper_convected}, {"isochoric", OldroydB::Form::isochoric}};
}

config::Names<ThixotropicHerschelBulkley::Kinetics> names(config::Of<ThixotropicHerschelBulkley::Kinetics>) {
  using K = ThixotropicHerschelBulkley::Kinetics;
  return {{"thixotropic", K::thixotropic}, {"rheopectic", K::rheopectic}};
}

const config::Keys<Newtonian::Parameters>& LawKeys<Newtonian>::table() {
  using P = Newtonian::Parameters;
  static const auto keys =
      config::Keys<P>("A fluid whose stress is proportional to the rate of deformation, slightly compressible.")
          .key("density", &P::density,
               {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = required})
          .key("bulk_modulus", &P::bulk_modulus,
               {.about = "Resistance to a change of volume; density times the square of the speed of sound.",
                .unit = "Pa",
                .range = config::above(0.0),
                .default_text = required})
          .key("viscosity", &P::viscosity,
               {.about = "Dynamic viscosity.", .unit = "Pa s", .range = config::at_least(0.0), .default_text = required})
          .key("tait_exponent", &P::tait_exponent,
               {.about = "Exponent n of the pressure (bulk_modulus / n) (J^-n - 1); 1: linear in the density.",
                .range = config::between(1.0, 20.0)})
          .key("tension", &P::tension,
               {.about = "Whether stretched fluid pulls; without, drops of a splash come apart freely."});
  return keys;
}

const config::Keys<OldroydB::Parameters>& LawKeys<OldroydB>::table() {
  using P = OldroydB::Parameters;
  static const auto keys =
      config::Keys<P>("A viscoelastic fluid: a polymer whose elastic stress relaxes, in a Newtonian solvent.")
          .key("density", &P::density,
               {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = required})
          .key("bulk_modulus", &P::bulk_modulus,
               {.about = "Resistance to a change of volume.",
                .unit = "Pa",
                .range = config::above(0.0),
                .default_text = required})
          .key("shear_modulus", &P::shear_modulus,
               {.about = "Elastic modulus of the polymer; times relaxation_time, its viscosity.",
                .unit = "Pa",
                .range = config::above(0.0),
                .default_text = required})
          .key("relaxation_time", &P::relaxation_time,
               {.about = "Time in which the polymer's stress falls to 1/e.",
                .unit = "s",
                .range = config::above(0.0),
                .default_text = required})
          .key("solvent_viscosity", &P::solvent_viscosity,
               {.about = "Dynamic viscosity of the solvent.", .unit = "Pa s", .range = config::at_least(0.0)})
          .key("form", &P::form,
               {.about =
                    "upper_convected: Oldroyd's fluid; isochoric: the polymer's strain is kept at constant volume, which "
                    "limits it (Ram et al. 2015)."});
  return keys;
}

const config::Keys<LawKeys<ThixotropicHerschelBulkley>::Input>& LawKeys<ThixotropicHerschelBulkley>::table() {
  static const auto keys = [] {
    config::Keys<Input> k(
        "A Herschel-Bulkley fluid whose yield stress and consistency follow a structure that flow breaks down (thixotropic) "
        "or "
        "builds up (rheopectic). The flow keys are those of the full structure.");
    add_flow_keys(k);
    k.key("kinetics", [](auto& s) -> auto& { return s.parameters.kinetics; },
          {.about = "thixotropic: flow breaks the structure down, rest builds it up; rheopectic: the reverse."})
        .key("build_up", [](auto& s) -> auto& { return s.parameters.build_up; },
             {.about = "Rate of the build-up; of a rheopectic fluid times the shear rate's power.",
              .unit = "1/s",
              .range = config::at_least(0.0),
              .default_text = required})
        .key("breakdown", [](auto& s) -> auto& { return s.parameters.breakdown; },
             {.about = "Rate of the breakdown; of a thixotropic fluid times the shear rate's power.",
              .unit = "s^(rate_exponent - 1)",
              .range = config::at_least(0.0),
              .default_text = required})
        .key("rate_exponent", [](auto& s) -> auto& { return s.parameters.rate_exponent; },
             {.about = "Power of the shear rate in the kinetics.", .range = config::above(0.0)})
        .key("yield_exponent", [](auto& s) -> auto& { return s.parameters.yield_exponent; },
             {.about = "Power of the structure in the yield stress.", .range = config::at_least(0.0)})
        .key("consistency_exponent", [](auto& s) -> auto& { return s.parameters.consistency_exponent; },
             {.about = "Power of the structure in the consistency.", .range = config::at_least(0.0)})
        .key(
            "residual_yield", [](auto& s) -> auto& { return s.parameters.residual_yield; },
            {.about = "Yield stress without structure over that of the full structure.", .range = config::between(0.0, 1.0)})
        .key("residual_consistency", [](auto& s) -> auto& { return s.parameters.residual_consistency; },
             {.about = "Consistency without structure over that of the full structure.", .range = config::between(0.0, 1.0)})
        .key("initial_structure", [](auto& s) -> auto& { return s.parameters.initial_structure; },
             {.about = "Structure at the start; 1: built up.", .range = config::between(0.0, 1.0)});
    return k;
  }();
  return keys;
}

void LawKeys<ThixotropicHerschelBulkley>::fill(const config::Value& table, const Input& input,
                                               ThixotropicHerschelBulkley& law, config::Faults& faults) {
  HerschelBulkley flow{law.parameters};
  LawKeys<HerschelBulkley>::fill(table, input, flow, faults);
  ThixotropicHerschelBulkley::Parameters p = input.parameters;
  static_cast<HerschelBulkley::Parameters&>(p) = flow.parameters;
  law = ThixotropicHerschelBulkley{p};
  if (std::isnan(p.build_up)) config::report_missing_key(table, "build_up", false, faults);
  if (std::isnan(p.breakdown)) config::report_missing_key(table, "breakdown", false, faults);
}

config::Value LawKeys<ThixotropicHerschelBulkley>::write(const ThixotropicHerschelBulkley& law) {
  Input input{flow_input(law.parameters), law.parameters};
  config::Value value = table().write(input);
  value.comment = rheometer_comment(law.parameters);
  return value;
}

}  // namespace bulkley
