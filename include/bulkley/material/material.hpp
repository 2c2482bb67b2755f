#pragma once
// The materials a particle can be made of: a family of laws, open through AddedLaw.

#include <span>
#include <string>
#include <variant>

#include "bulkley/material/added_law.hpp"
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
                              ThixotropicHerschelBulkley, DruckerPrager, Snow, AddedLaw>;

struct NamedMaterial {
  std::string name;
  Material material;
  std::string caveat = {};  ///< what a user should know of its numbers; empty as a rule
};

/// Throws UsageError naming the material and the parameter that is out of range. Not collective.
void require_valid(const NamedMaterial& named);

/// The internal variables of a material's law. Not collective.
std::span<const Internal> internal_variables(const Material& material);

/// The name of a material's law in scenes. Not collective.
const char* law_name(const Material& material);

/// Whether a material deforms for good, as fluids do. Not collective.
bool flows(const Material& material);

}  // namespace bulkley
