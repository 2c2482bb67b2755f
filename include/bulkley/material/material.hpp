#pragma once
// The materials a particle can be made of: a closed family of laws.

#include <string>
#include <variant>

#include "bulkley/material/herschel_bulkley.hpp"
#include "bulkley/material/neo_hookean.hpp"

namespace bulkley {

using Material = std::variant<NeoHookean, HerschelBulkley>;

struct NamedMaterial {
  std::string name;
  Material material;
};

/// Throws UsageError naming the material and the parameter that is out of range. Not collective.
void require_valid(const NamedMaterial& named);

}  // namespace bulkley
