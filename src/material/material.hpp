#pragma once
// The materials a particle can be made of: a family of laws, open through AddedLaw.

#include <span>
#include <string>
#include <variant>

#include "bulkley/material/added_law.hpp"
#include "material/laws/drucker_prager.hpp"
#include "material/laws/finite_viscoelastic.hpp"
#include "material/laws/fixed_corotated.hpp"
#include "material/laws/hencky.hpp"
#include "material/laws/herschel_bulkley.hpp"
#include "material/laws/neo_hookean.hpp"
#include "material/laws/newtonian.hpp"
#include "material/laws/oldroyd_b.hpp"
#include "material/laws/snow.hpp"
#include "material/laws/thixotropic.hpp"

namespace bulkley {

using Material = std::variant<NeoHookean, HerschelBulkley, Hencky, FixedCorotated, Newtonian, OldroydB, FiniteViscoelastic,
                              ThixotropicHerschelBulkley, DruckerPrager, Snow, AddedLaw>;

struct NamedMaterial {
  std::string name;
  Material material;
  std::string caveat = {};  ///< what a user should know of its numbers; empty as a rule
};

/// The internal variables of a material's law. Not collective.
std::span<const Internal> internal_variables(const Material& material);

/// The name of a material's law in scenes. Not collective.
const char* law_name(const Material& material);

/// Whether a material deforms for good, as fluids do. Not collective.
bool flows(const Material& material);

}  // namespace bulkley
