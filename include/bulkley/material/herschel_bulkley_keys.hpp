#pragma once
// Keys of [materials.NAME] with law = "herschel_bulkley".

#include "bulkley/material/material_keys.hpp"

namespace bulkley {

/// The flow parameters stand in one of two conventions, never mixed (docs/theory.md, "Herschel-Bulkley").
struct HerschelBulkleyInput {
  std::optional<double> density, bulk_modulus, shear_modulus;
  std::optional<double> yield_stress, consistency, flow_index;  ///< shear rheometer: tau = tau_y + K shear_rate^n
  std::optional<double> sigma_Y, eta, h;                        ///< Yue et al. 2015
};

template <>
struct LawKeys<HerschelBulkley> {
  using Input = HerschelBulkleyInput;
  static const config::Keys<Input>& table();
  static void fill(const config::Value& table, const Input& input, HerschelBulkley& law, config::Faults& faults);
  static config::Value write(const HerschelBulkley& law);
};

}  // namespace bulkley
