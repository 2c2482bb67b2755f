#pragma once
// The materials a particle can be made of: a family of laws, open through AddedLaw.

#include <optional>
#include <span>
#include <string>
#include <variant>

#include "bulkley/material/added_law.hpp"
#include "magnetics/magnetisation.hpp"
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

/// The list of laws: one of the library is its header above and its name here.
using Material = std::variant<NeoHookean, HerschelBulkley, Hencky, FixedCorotated, Newtonian, OldroydB, FiniteViscoelastic,
                              ThixotropicHerschelBulkley, DruckerPrager, Snow, AddedLaw>;

struct NamedMaterial {
  std::string name;
  Material material;
  std::string caveat = {};                          ///< what a user should know of its numbers; empty as a rule
  std::optional<Magnetisation> magnetisation = {};  ///< of a magnetic material
};

/// The neo-Hookean solid whose stress a particle of this material has by its b and J; none where its stress takes more than
/// these, or much work. Not collective.
std::optional<NeoHookean> neo_hookean_stress(const Material& material);

/// What is wrong with a material's parameters, as one sentence; empty when nothing is. Not collective.
std::optional<std::string> material_fault(const Material& material);

/// The fields that hold what a material's law keeps in addition to b and J. Not collective.
std::span<const Field> internal_variables(const Material& material);

/// What a magnetic field adds to the yield stress; none for a law without one. Not collective.
FieldYield field_yield(const Material& material);
/// The material with that. Not collective. Precondition: a Herschel-Bulkley fluid, thixotropic or not.
Material with_field_yield(const Material& material, const FieldYield& yield);
/// Whether a material's law can have one. Not collective.
bool takes_field_yield(const Material& material);
/// The material as it is where the magnetic field has the strength `field` (A/m, >= 0): a larger yield stress instead of one that
/// depends on the field. Not collective.
Material at_field(const Material& material, double field);

/// The shear stress at a shear rate (1/s), if the law has one. Not collective.
std::optional<CharacteristicStress> characteristic_stress(const Material& material, double rate);

/// The name of a material's law in scenes. Not collective.
const char* law_name(const Material& material);

/// Density of the material as it starts, kg/m^3. Not collective.
double rest_density(const Material& material);

/// Speed of a shear wave in the material at rest, m/s; 0 where it holds no shear stress. Not collective.
double shear_wave_speed_at_rest(const Material& material);

/// What of a material's stress depends on volume alone; none where its law does not keep it apart. Not collective.
std::optional<VolumetricLaw> volumetric_law(const Material& material);

/// The material with another bulk modulus in that part, Pa; one without that part as it is. Not collective.
Material with_bulk_modulus(const Material& material, double bulk_modulus);
/// The material without that part: its stress is the rest of the law's, its waves are those of shear. Not collective.
Material without_volumetric_law(const Material& material);

/// The viscosity of a stress that follows the rate of deformation at once and that a step may treat implicitly, Pa s; 0 where there
/// is none, and for laws that a program has added. Not collective.
double separable_viscosity(const Material& material);

/// The material without that stress. Not collective.
Material without_viscosity(const Material& material);

/// Whether a material is a Herschel-Bulkley fluid, thixotropic or not, that has a yield stress, if only in a magnetic field. Not collective.
bool has_yield_stress(const Material& material);

/// Whether a material deforms irreversibly, as fluids do. Not collective.
bool flows(const Material& material);

}  // namespace bulkley
