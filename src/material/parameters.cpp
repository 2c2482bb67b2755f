#include <fmt/format.h>

#include <cmath>

#include "material/material.hpp"

namespace bulkley {

namespace {

using Fault = std::optional<std::string>;

Fault require(bool holds, const char* name, double value, const char* range) {
  if (holds) return std::nullopt;
  if (std::isnan(value)) return fmt::format("{} is not given; it must be {}", name, range);
  return fmt::format("{} = {} must be {}", name, value, range);
}
Fault require_positive(const char* name, double value) {
  return require(value > 0.0 && std::isfinite(value), name, value, "positive and finite");
}
Fault require_non_negative(const char* name, double value) {
  return require(value >= 0.0 && std::isfinite(value), name, value, "at least 0 and finite");
}

}  // namespace

std::optional<std::string> parameter_fault(const NeoHookean::Parameters& p) {
  if (auto fault = require_positive("density", p.density)) return fault;
  if (auto fault = require_positive("bulk_modulus", p.bulk_modulus)) return fault;
  return require_non_negative("shear_modulus", p.shear_modulus);
}

std::optional<std::string> parameter_fault(const HerschelBulkley::Parameters& p) {
  if (auto fault = parameter_fault(NeoHookean::Parameters{p.density, p.bulk_modulus, p.shear_modulus})) return fault;
  if (auto fault = require_non_negative("sigma_Y", p.sigma_Y)) return fault;
  if (auto fault = require(p.eta >= 0.0, "eta", p.eta, "at least 0 (infinity: elastic)")) return fault;
  if (auto fault = require(p.h >= 0.1 && p.h <= 3.0, "h", p.h, "from 0.1 to 3")) return fault;
  return require_non_negative("background_viscosity", p.background_viscosity);
}

std::optional<std::string> parameter_fault(const Newtonian::Parameters& p) {
  if (auto fault = require_positive("density", p.density)) return fault;
  if (auto fault = require_positive("bulk_modulus", p.bulk_modulus)) return fault;
  if (auto fault = require_non_negative("viscosity", p.viscosity)) return fault;
  return require(p.tait_exponent >= 1.0 && p.tait_exponent <= 20.0, "tait_exponent", p.tait_exponent, "from 1 to 20");
}

std::optional<std::string> parameter_fault(const OldroydB::Parameters& p) {
  if (auto fault = require_positive("density", p.density)) return fault;
  if (auto fault = require_positive("bulk_modulus", p.bulk_modulus)) return fault;
  if (auto fault = require_positive("shear_modulus", p.shear_modulus)) return fault;
  if (auto fault = require_positive("relaxation_time", p.relaxation_time)) return fault;
  return require_non_negative("solvent_viscosity", p.solvent_viscosity);
}

std::optional<std::string> parameter_fault(const FiniteViscoelastic::Parameters& p) {
  if (auto fault = parameter_fault(static_cast<const NeoHookean::Parameters&>(p))) return fault;
  if (auto fault = require_positive("branch_shear_modulus", p.branch_shear_modulus)) return fault;
  if (auto fault = require_non_negative("branch_bulk_modulus", p.branch_bulk_modulus)) return fault;
  if (auto fault = require_positive("relaxation_time", p.relaxation_time)) return fault;
  return require(p.bulk_relaxation_time > 0.0, "bulk_relaxation_time", p.bulk_relaxation_time, "positive");
}

std::optional<std::string> parameter_fault(const ThixotropicHerschelBulkley::Parameters& p) {
  const auto require_fraction = [](const char* name, double value) {
    return require(value >= 0.0 && value <= 1.0, name, value, "from 0 to 1");
  };
  if (auto fault = parameter_fault(static_cast<const HerschelBulkley::Parameters&>(p))) return fault;
  if (auto fault = require_non_negative("eta", p.eta)) return fault;
  if (auto fault = require_non_negative("build_up", p.build_up)) return fault;
  if (auto fault = require_non_negative("breakdown", p.breakdown)) return fault;
  if (auto fault = require_positive("rate_exponent", p.rate_exponent)) return fault;
  if (auto fault = require_non_negative("yield_exponent", p.yield_exponent)) return fault;
  if (auto fault = require_non_negative("consistency_exponent", p.consistency_exponent)) return fault;
  if (auto fault = require_fraction("residual_yield", p.residual_yield)) return fault;
  if (auto fault = require_fraction("residual_consistency", p.residual_consistency)) return fault;
  return require_fraction("initial_structure", p.initial_structure);
}

std::optional<std::string> parameter_fault(const DruckerPrager::Parameters& p) {
  if (auto fault = parameter_fault(static_cast<const NeoHookean::Parameters&>(p))) return fault;
  if (auto fault = require_positive("shear_modulus", p.shear_modulus)) return fault;
  const auto require_angle = [](const char* name, double value) {
    return require(value > 0.0 && value <= 60.0, name, value, "above 0 and at most 60 degrees");
  };
  if (auto fault = require_angle("friction_angle", p.friction_angle)) return fault;
  if (auto fault = require_non_negative("cohesion", p.cohesion)) return fault;
  if (auto fault = require_non_negative("hardening_rise", p.hardening_rise)) return fault;
  if (auto fault = require_non_negative("hardening_decay", p.hardening_decay)) return fault;
  if (auto fault = require_non_negative("hardening_drop", p.hardening_drop)) return fault;
  if (auto fault = require_angle("friction_angle - hardening_drop", p.friction_angle - p.hardening_drop)) return fault;
  if (p.hardening_rise == 0.0) return std::nullopt;
  if (auto fault = require_positive("hardening_decay", p.hardening_decay)) return fault;
  // The angle is largest where its derivative by q vanishes.
  const double q = 1.0 / p.hardening_decay + p.hardening_drop / p.hardening_rise;
  return require_angle("the largest friction angle that hardening reaches",
                       p.friction_angle + (p.hardening_rise * q - p.hardening_drop) * std::exp(-p.hardening_decay * q));
}

std::optional<std::string> parameter_fault(const Snow::Parameters& p) {
  if (auto fault = parameter_fault(static_cast<const NeoHookean::Parameters&>(p))) return fault;
  if (auto fault = require(p.critical_compression > 0.0 && p.critical_compression < 1.0, "critical_compression",
                           p.critical_compression, "above 0 and below 1"))
    return fault;
  if (auto fault = require_positive("critical_stretch", p.critical_stretch)) return fault;
  return require_non_negative("hardening", p.hardening);
}

std::span<const Internal> internal_variables(const Material& material) {
  return std::visit([]<class Law>(const Law&) { return std::span<const Internal>(Law::internal); }, material);
}

const char* law_name(const Material& material) {
  if (const auto* added = std::get_if<AddedLaw>(&material)) return added->parameters.model->name();
  return std::visit([](const auto& law) { return law.law_name; }, material);
}

bool flows(const Material& material) {
  if (const auto* added = std::get_if<AddedLaw>(&material)) return added->parameters.model->flows();
  return std::visit([](const auto& law) { return law.flows; }, material);
}

NeoHookean::Parameters from_youngs_modulus(double density, double youngs_modulus, double poisson_ratio) {
  return {density, youngs_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio)), youngs_modulus / (2.0 * (1.0 + poisson_ratio))};
}

ShearRheometerConstants shear_rheometer_constants(const HerschelBulkley::Parameters& p) {
  return {p.sigma_Y / std::sqrt(3.0), p.eta * std::exp2(-0.5 * (1.0 + p.h)), p.h};
}

void set_flow(HerschelBulkley::Parameters& p, const ShearRheometerConstants& constants) {
  p.sigma_Y = std::sqrt(3.0) * constants.yield_stress;
  p.eta = constants.consistency * std::exp2(0.5 * (1.0 + constants.flow_index));
  p.h = constants.flow_index;
}

}  // namespace bulkley
