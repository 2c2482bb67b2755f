#include "material/laws/herschel_bulkley_keys.hpp"

#include <fmt/format.h>

#include <cmath>

#include "config/groups.hpp"

namespace bulkley {
namespace {

const std::vector<std::string> rheometer_names{"yield_stress", "consistency", "flow_index"};
const std::vector<std::string> yue_names{"sigma_Y", "eta", "h"};

void assign(const std::optional<double>& from, double& to) {
  if (from) to = *from;
}

}  // namespace

const config::Keys<HerschelBulkleyInput>& LawKeys<HerschelBulkley>::table() {
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

void LawKeys<HerschelBulkley>::fill(const config::Value& table, const Input& input, HerschelBulkley& law,
                                    config::Faults& faults) {
  if (config::refuse_mixture(table, yue_names, "Yue's convention", rheometer_names, "the shear rheometer's", faults)) return;
  HerschelBulkley::Parameters p = law.parameters;
  assign(input.density, p.density);
  assign(input.bulk_modulus, p.bulk_modulus);
  assign(input.shear_modulus, p.shear_modulus);
  assign(input.background_viscosity, p.background_viscosity);
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

HerschelBulkleyInput flow_input(const HerschelBulkley::Parameters& p) {
  HerschelBulkleyInput input;
  input.density = p.density;
  input.bulk_modulus = p.bulk_modulus;
  input.shear_modulus = p.shear_modulus;
  input.sigma_Y = p.sigma_Y;
  input.eta = p.eta;
  input.h = p.h;
  input.background_viscosity = p.background_viscosity;
  return input;
}

std::string rheometer_comment(const HerschelBulkley::Parameters& p) {
  const ShearRheometerConstants flow = shear_rheometer_constants(p);
  return fmt::format(
      "in the shear rheometer's convention: yield_stress = {:.6g} Pa, consistency = {:.6g} Pa s^n, "
      "flow_index = {:.6g}",
      flow.yield_stress, flow.consistency, flow.flow_index);
}

config::Value LawKeys<HerschelBulkley>::write(const HerschelBulkley& law) {
  config::Value value = table().write(flow_input(law.parameters));
  value.comment = rheometer_comment(law.parameters);
  return value;
}

}  // namespace bulkley
