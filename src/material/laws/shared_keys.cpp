#include "material/laws/shared_keys.hpp"

#include <fmt/format.h>

#include <cmath>

#include "config/groups.hpp"
#include "material/laws/neo_hookean.hpp"

namespace bulkley {
namespace {

const std::vector<std::string> rheometer_names{"yield_stress", "consistency", "flow_index"};
const std::vector<std::string> yue_names{"sigma_Y", "eta", "h"};

void assign(const std::optional<double>& from, double& to) {
  if (from) to = *from;
}

}  // namespace

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

void fill_flow(const config::Value& table, const HerschelBulkleyInput& input, HerschelBulkley::Parameters& p,
               config::Faults& faults) {
  if (config::refuse_mixture(table, yue_names, "Yue's convention", rheometer_names, "the shear rheometer's", faults)) return;
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
    p.given = flow;
  } else {
    p.given = {};
    assign(input.sigma_Y, p.sigma_Y);
    assign(input.eta, p.eta);
    assign(input.h, p.h);
  }

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
  if (is_as_given(p)) {
    input.yield_stress = p.given.yield_stress;
    input.consistency = p.given.consistency;
    input.flow_index = p.given.flow_index;
  } else {
    input.sigma_Y = p.sigma_Y;
    input.eta = p.eta;
    input.h = p.h;
  }
  input.background_viscosity = p.background_viscosity;
  return input;
}

std::string flow_comment(const HerschelBulkley::Parameters& p) {
  if (is_as_given(p))
    return fmt::format("in Yue's convention: sigma_Y = {:.6g} Pa, eta = {:.6g} Pa s^h, h = {:.6g}", p.sigma_Y, p.eta, p.h);
  const ShearRheometerConstants flow = shear_rheometer_constants(p);
  return fmt::format(
      "in the shear rheometer's convention: yield_stress = {:.6g} Pa, consistency = {:.6g} Pa s^n, "
      "flow_index = {:.6g}",
      flow.yield_stress, flow.consistency, flow.flow_index);
}

}  // namespace bulkley
