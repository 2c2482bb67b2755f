#include "material/laws/herschel_bulkley.hpp"

#include <cmath>

#include "material/laws/shared_keys.hpp"

namespace bulkley {

ShearRheometerConstants shear_rheometer_constants(const HerschelBulkley::Parameters& p) {
  return {p.sigma_Y / std::sqrt(3.0), p.eta * std::exp2(-0.5 * (1.0 + p.h)), p.h};
}

void set_flow(HerschelBulkley::Parameters& p, const ShearRheometerConstants& constants) {
  p.sigma_Y = std::sqrt(3.0) * constants.yield_stress;
  p.eta = constants.consistency * std::exp2(0.5 * (1.0 + constants.flow_index));
  p.h = constants.flow_index;
}

bool is_as_given(const HerschelBulkley::Parameters& p) {
  HerschelBulkley::Parameters again = p;
  set_flow(again, p.given);
  return again.sigma_Y == p.sigma_Y && again.eta == p.eta && again.h == p.h;
}

CharacteristicStress HerschelBulkley::characteristic_stress(const Parameters& parameters, double rate) {
  const ShearRheometerConstants c = shear_rheometer_constants(parameters);
  return {c.yield_stress + c.consistency * std::pow(rate, c.flow_index) + parameters.background_viscosity * rate,
          c.yield_stress};
}

template <>
struct LawKeys<HerschelBulkley> {
  using Input = HerschelBulkleyInput;
  static Input start(const HerschelBulkley&) { return {}; }
  static const config::Keys<Input>& table() {
    static const auto keys = [] {
      config::Keys<Input> k(
          "A fluid that flows above a yield stress and is elastic below it. The flow is given by `yield_stress`, "
          "`consistency` "
          "and `flow_index` as a shear rheometer reports them, or by `sigma_Y`, `eta` and `h` of Yue et al. (2015); never "
          "mixed: sigma_Y = sqrt(3) yield_stress, eta = 2^((1 + n)/2) consistency.");
      add_flow_keys(k);
      return k;
    }();
    return keys;
  }
  static void fill(const config::Value& table, const Input& input, HerschelBulkley& law, config::Faults& faults) {
    HerschelBulkley::Parameters p = law.parameters;
    fill_flow(table, input, p, faults);
    law = HerschelBulkley{p};
  }
  static Input input(const HerschelBulkley& law) { return flow_input(law.parameters); }
  static config::Value write(const HerschelBulkley& law) {
    config::Value value = table().write(input(law));
    value.comment = flow_comment(law.parameters);
    return value;
  }
};

template struct LawText<HerschelBulkley>;

}  // namespace bulkley
