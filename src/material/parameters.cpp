#include <fmt/format.h>

#include <cmath>

#include "bulkley/base/error.hpp"
#include "bulkley/material/material.hpp"

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
  return require(p.h >= 0.1 && p.h <= 3.0, "h", p.h, "from 0.1 to 3");
}

void require_valid(const NamedMaterial& named) {
  const Fault fault = std::visit([](const auto& law) { return parameter_fault(law.parameters); }, named.material);
  if (fault) throw UsageError(fmt::format("material '{}': {}", named.name, *fault));
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
