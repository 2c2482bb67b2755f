#pragma once
// Keys of [materials.NAME] with law = "neo_hookean".

#include "bulkley/material/material_keys.hpp"

namespace bulkley {

/// The stiffness as bulk and shear modulus, or as Young's modulus and Poisson's ratio, never mixed.
struct NeoHookeanInput {
  std::optional<double> density, bulk_modulus, shear_modulus, youngs_modulus, poisson_ratio;
};

template <>
struct LawKeys<NeoHookean> {
  using Input = NeoHookeanInput;
  static const config::Keys<Input>& table();
  static void fill(const config::Value& table, const Input& input, NeoHookean& law, config::Faults& faults);
  static config::Value write(const NeoHookean& law);
};

}  // namespace bulkley
