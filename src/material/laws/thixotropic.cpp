#include "material/laws/thixotropic.hpp"

#include <cmath>

#include "material/laws/shared_keys.hpp"

namespace bulkley {

config::Names<ThixotropicHerschelBulkley::Kinetics> names(config::Of<ThixotropicHerschelBulkley::Kinetics>) {
  using K = ThixotropicHerschelBulkley::Kinetics;
  return {{"thixotropic", K::thixotropic}, {"rheopectic", K::rheopectic}};
}

std::optional<std::string> parameter_fault(const ThixotropicHerschelBulkley::Parameters& p) {
  if (std::isinf(p.eta)) return "eta = inf must be finite";
  return std::nullopt;
}

/// The flow keys of Herschel-Bulkley for the full structure, and those of the structure.
template <>
struct LawKeys<ThixotropicHerschelBulkley> {
  struct Input : HerschelBulkleyInput {
    ThixotropicHerschelBulkley::Parameters parameters;
  };
  static Input start(const ThixotropicHerschelBulkley& law) { return {{}, law.parameters}; }
  static const config::Keys<Input>& table() {
    static const auto keys = [] {
      config::Keys<Input> k(
          "A Herschel-Bulkley fluid whose yield stress and consistency follow a structure that flow breaks down "
          "(thixotropic) "
          "or "
          "builds up (rheopectic). The flow keys are those of the full structure.");
      add_flow_keys(k);
      k.key("kinetics", [](auto& s) -> auto& { return s.parameters.kinetics; },
            {.about = "thixotropic: flow breaks the structure down, rest builds it up; rheopectic: the reverse."})
          .key("build_up", [](auto& s) -> auto& { return s.parameters.build_up; },
               {.about = "Rate of the build-up; of a rheopectic fluid times the shear rate's power.",
                .unit = "1/s",
                .range = config::at_least(0.0),
                .default_text = required_key})
          .key("breakdown", [](auto& s) -> auto& { return s.parameters.breakdown; },
               {.about = "Rate of the breakdown; of a thixotropic fluid times the shear rate's power.",
                .unit = "s^(rate_exponent - 1)",
                .range = config::at_least(0.0),
                .default_text = required_key})
          .key("rate_exponent", [](auto& s) -> auto& { return s.parameters.rate_exponent; },
               {.about = "Power of the shear rate in the kinetics.", .range = config::above(0.0)})
          .key("yield_exponent", [](auto& s) -> auto& { return s.parameters.yield_exponent; },
               {.about = "Power of the structure in the yield stress.", .range = config::at_least(0.0)})
          .key("consistency_exponent", [](auto& s) -> auto& { return s.parameters.consistency_exponent; },
               {.about = "Power of the structure in the consistency.", .range = config::at_least(0.0)})
          .key("residual_yield", [](auto& s) -> auto& { return s.parameters.residual_yield; },
               {.about = "Yield stress without structure over that of the full structure.",
                .range = config::between(0.0, 1.0)})
          .key("residual_consistency", [](auto& s) -> auto& { return s.parameters.residual_consistency; },
               {.about = "Consistency without structure over that of the full structure.",
                .range = config::between(0.0, 1.0)})
          .key("initial_structure", [](auto& s) -> auto& { return s.parameters.initial_structure; },
               {.about = "Structure at the start; 1: built up.", .range = config::between(0.0, 1.0)});
      return k;
    }();
    return keys;
  }
  static void fill(const config::Value& table, const Input& input, ThixotropicHerschelBulkley& law, config::Faults& faults) {
    ThixotropicHerschelBulkley::Parameters p = input.parameters;
    fill_flow(table, input, p, faults);
    law = ThixotropicHerschelBulkley{p};
    if (std::isnan(p.build_up)) config::report_missing_key(table, "build_up", false, faults);
    if (std::isnan(p.breakdown)) config::report_missing_key(table, "breakdown", false, faults);
  }
  static Input input(const ThixotropicHerschelBulkley& law) { return {flow_input(law.parameters), law.parameters}; }
  static config::Value write(const ThixotropicHerschelBulkley& law) {
    config::Value value = table().write(input(law));
    value.comment = flow_comment(law.parameters);
    return value;
  }
};

template struct LawText<ThixotropicHerschelBulkley>;

}  // namespace bulkley
