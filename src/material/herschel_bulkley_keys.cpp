#include "bulkley/material/herschel_bulkley_keys.hpp"

#include <fmt/format.h>

#include <cmath>

#include "bulkley/config/groups.hpp"

namespace bulkley {
namespace {

const std::vector<std::string> rheometer_names{"yield_stress", "consistency", "flow_index"};
const std::vector<std::string> yue_names{"sigma_Y", "eta", "h"};

void assign(const std::optional<double>& from, double& to) {
  if (from) to = *from;
}

}  // namespace

const config::Keys<HerschelBulkleyInput>& LawKeys<HerschelBulkley>::table() {
  using Input = HerschelBulkleyInput;
  constexpr auto flow_range = config::between(0.1, 3.0);
  const std::string elsewhere = "from `preset`, else required";
  const std::string either = "from `preset`, else required in one convention";
  static const auto keys =
      config::Keys<Input>(
          "A fluid that flows above a yield stress and is elastic below it. The flow is given by `yield_stress`, "
          "`consistency` "
          "and `flow_index` as a shear rheometer reports them, or by `sigma_Y`, `eta` and `h` of Yue et al. (2015); never "
          "mixed: sigma_Y = sqrt(3) yield_stress, eta = 2^((1 + n)/2) consistency.")
          .key("density", &Input::density,
               {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = elsewhere})
          .key("bulk_modulus", &Input::bulk_modulus,
               {.about = "Resistance to a change of volume.",
                .unit = "Pa",
                .range = config::above(0.0),
                .default_text = elsewhere})
          .key("shear_modulus", &Input::shear_modulus,
               {.about = "Elastic resistance to shear.",
                .unit = "Pa",
                .range = config::at_least(0.0),
                .default_text = elsewhere})
          .key("yield_stress", &Input::yield_stress,
               {.about = "Shear stress at which the fluid begins to flow: tau = yield_stress + consistency * "
                         "shear_rate^flow_index.",
                .unit = "Pa",
                .range = config::at_least(0.0),
                .default_text = either})
          .key("consistency", &Input::consistency,
               {.about = "Factor of the shear rate's power.",
                .unit = "Pa s^n",
                .range = config::at_least(0.0),
                .default_text = either})
          .key("flow_index", &Input::flow_index,
               {.about = "Power n of the shear rate; below 1 the fluid thins with the rate, above it thickens.",
                .unit = "",
                .range = flow_range,
                .default_text = either})
          .key("sigma_Y", &Input::sigma_Y,
               {.about = "Yield stress in uniaxial (von Mises) terms.",
                .unit = "Pa",
                .range = config::at_least(0.0),
                .default_text = either})
          .key("eta", &Input::eta,
               {.about = "Viscosity of Yue's flow rule; 0: perfectly plastic.",
                .unit = "Pa s^h",
                .range = config::at_least(0.0),
                .default_text = either})
          .key("h", &Input::h,
               {.about = "Power of Yue's flow rule, the same as flow_index.", .range = flow_range, .default_text = either});
  return keys;
}

void LawKeys<HerschelBulkley>::fill(const config::Value& table, const Input& input, HerschelBulkley& law,
                                    config::Faults& faults) {
  if (config::refuse_mixture(table, yue_names, "Yue's convention", rheometer_names, "the shear rheometer's", faults)) return;
  HerschelBulkley::Parameters p = law.parameters;
  assign(input.density, p.density);
  assign(input.bulk_modulus, p.bulk_modulus);
  assign(input.shear_modulus, p.shear_modulus);
  const bool rheometer = config::first_given(table, rheometer_names) != nullptr;
  ShearRheometerConstants flow = shear_rheometer_constants(p);
  if (rheometer) {
    assign(input.yield_stress, flow.yield_stress);
    assign(input.consistency, flow.consistency);
    assign(input.flow_index, flow.flow_index);
    set_flow(p, flow);
  } else {
    assign(input.sigma_Y, p.sigma_Y);
    assign(input.eta, p.eta);
    assign(input.h, p.h);
  }
  law = HerschelBulkley{p};

  const auto require = [&](const std::string& name, double value) {
    if (std::isnan(value)) config::report_missing_key(table, name, false, faults);
  };
  require("density", p.density);
  require("bulk_modulus", p.bulk_modulus);
  require("shear_modulus", p.shear_modulus);
  if (rheometer) {
    require("yield_stress", flow.yield_stress);
    require("consistency", flow.consistency);
    require("flow_index", flow.flow_index);
  } else if (std::isnan(p.sigma_Y) && std::isnan(p.eta) && std::isnan(p.h)) {
    faults.add(table.place,
               fmt::format("{} needs 'yield_stress', 'consistency' and 'flow_index' (shear rheometer) or 'sigma_Y', "
                           "'eta' and 'h' (Yue et al. 2015)",
                           config::table_name(table.path)));
  } else {
    require("sigma_Y", p.sigma_Y);
    require("eta", p.eta);
    require("h", p.h);
  }
}

config::Value LawKeys<HerschelBulkley>::write(const HerschelBulkley& law) {
  const HerschelBulkley::Parameters& p = law.parameters;
  Input input;
  input.density = p.density;
  input.bulk_modulus = p.bulk_modulus;
  input.shear_modulus = p.shear_modulus;
  input.sigma_Y = p.sigma_Y;
  input.eta = p.eta;
  input.h = p.h;
  config::Value value = table().write(input);
  const ShearRheometerConstants flow = shear_rheometer_constants(p);
  value.comment = fmt::format(
      "in the shear rheometer's convention: yield_stress = {:.6g} Pa, consistency = {:.6g} Pa s^n, "
      "flow_index = {:.6g}",
      flow.yield_stress, flow.consistency, flow.flow_index);
  return value;
}

}  // namespace bulkley
