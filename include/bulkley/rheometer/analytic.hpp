#pragma once
// What theory says of the measurements, for the laws whose answer is known. Other laws have no analytic curve. Stresses and
// moduli are those of the Kirchhoff stress; under a pressure the Cauchy stress is that over J, which no shear changes.

#include <optional>

#include "bulkley/rheometer/specimen.hpp"

namespace bulkley::rheometer {

struct SteadyFlow {
  double stress;               ///< sigma_xy in shear, sigma_xx - sigma_yy in extension, Pa, with the elastic strain as it is
  double small_strain_stress;  ///< the same in the limit of a stiff material, Pa: tau_y + K rate^n in shear
  double first_normal_difference;  ///< Pa; in extension the stress itself
};

/// Steady flow at a rate (1/s, > 0) of a Herschel-Bulkley fluid with shear_modulus > 0 and finite eta: the solution of (T17)
/// and (T18) in continuous time (docs/rheometer.md). Not collective.
std::optional<SteadyFlow> steady_flow(const Material& material, Flow flow, double rate);

/// The shear rate at which steady shear stress is `stress` (Pa): the inverse of steady_flow; 0 at and below yield. Nothing
/// where no steady flow carries the stress. Not collective.
std::optional<double> steady_shear_rate(const Material& material, double stress);

/// Stress of a neo-Hookean solid at a strain (Hencky in extension), and its first normal stress difference, Pa. Not
/// collective.
std::optional<SteadyFlow> solid_stress(const Material& material, Flow flow, double strain);

/// A fluid of one relaxation time.
struct MaxwellFluid {
  double modulus;          ///< Pa
  double relaxation_time;  ///< s; infinity: an elastic solid
};

/// A Herschel-Bulkley fluid with sigma_Y = 0 and h = 1, in the limit of small elastic strain, or a neo-Hookean solid. Not
/// collective.
std::optional<MaxwellFluid> maxwell_limit(const Material& material);

struct DynamicModuli {
  double storage, loss;  ///< G' and G'', Pa
};

/// G' and G'' at an angular frequency (rad/s). Not collective.
DynamicModuli dynamic_moduli(const MaxwellFluid& fluid, double angular_frequency);

}  // namespace bulkley::rheometer
