#pragma once
// Analytic solutions of the measurements, for laws where they are known. Other laws have no analytic curve. Stresses are
// Cauchy stresses of a specimen compressed to the volume ratio J, which no shear changes.

#include <optional>

#include "rheometer/specimen.hpp"

namespace bulkley::rheometer {

struct SteadyFlow {
  double stress;               ///< sigma_xy in shear, sigma_xx - sigma_yy in extension, Pa, with the elastic strain as it is
  double small_strain_stress;  ///< the same in the limit of a stiff material, Pa: tau_y + K rate^n in shear
  double first_normal_difference;  ///< Pa; in extension the stress itself
};

/// Steady flow at a rate (1/s, > 0): of a (thixotropic) Herschel-Bulkley fluid with shear_modulus > 0 and finite eta, the
/// solution of (T17) and (T18) in continuous time (docs/rheometer.md) with the structure in balance; of a Newtonian fluid;
/// of an upper convected Oldroyd-B fluid, in extension below the rate at which its stress grows without bound. Not
/// collective.
std::optional<SteadyFlow> steady_flow(const Material& material, Flow flow, double rate, double J = 1.0);

/// The shear rate at which the steady shear stress of a Herschel-Bulkley fluid is `stress` (Pa): the inverse of steady_flow;
/// 0 at and below yield. Nothing where no steady flow carries the stress. Not collective.
std::optional<double> steady_shear_rate(const Material& material, double stress, double J = 1.0);

/// Stress of a neo-Hookean solid at a strain (Hencky in extension), and its first normal stress difference, Pa. Not
/// collective.
std::optional<SteadyFlow> solid_stress(const Material& material, Flow flow, double strain, double J = 1.0);

/// A fluid of one relaxation time, and a Newtonian one in parallel.
struct MaxwellFluid {
  double modulus;           ///< Pa
  double relaxation_time;   ///< s; infinity: an elastic solid
  double viscosity_beside;  ///< Pa s
};

/// A Herschel-Bulkley fluid with sigma_Y = 0 and h = 1, in the limit of small elastic strain; an upper convected Oldroyd-B
/// fluid; a neo-Hookean solid. Not collective.
std::optional<MaxwellFluid> maxwell_limit(const Material& material, double J = 1.0);

struct DynamicModuli {
  double storage, loss;  ///< G' and G'', Pa
};

/// G' and G'' at an angular frequency (rad/s). Not collective.
DynamicModuli dynamic_moduli(const MaxwellFluid& fluid, double angular_frequency);

}  // namespace bulkley::rheometer
