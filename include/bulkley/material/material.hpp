#pragma once
// The materials a particle can be made of: a closed family of laws.

#include <span>
#include <string>
#include <variant>

#include "bulkley/material/drucker_prager.hpp"
#include "bulkley/material/finite_viscoelastic.hpp"
#include "bulkley/material/fixed_corotated.hpp"
#include "bulkley/material/hencky.hpp"
#include "bulkley/material/herschel_bulkley.hpp"
#include "bulkley/material/neo_hookean.hpp"
#include "bulkley/material/newtonian.hpp"
#include "bulkley/material/oldroyd_b.hpp"
#include "bulkley/material/snow.hpp"
#include "bulkley/material/thixotropic.hpp"

namespace bulkley {

using Material = std::variant<NeoHookean, HerschelBulkley, Hencky, FixedCorotated, Newtonian, OldroydB, FiniteViscoelastic,
                              ThixotropicHerschelBulkley, DruckerPrager, Snow>;

struct NamedMaterial {
  std::string name;
  Material material;
  std::string caveat = {};  ///< what a user should know of its numbers; empty as a rule
};

/// Throws UsageError naming the material and the parameter that is out of range. Not collective.
void require_valid(const NamedMaterial& named);

/// The internal variables of a material's law. Not collective.
std::span<const Internal> internal_variables(const Material& material);

}  // namespace bulkley
