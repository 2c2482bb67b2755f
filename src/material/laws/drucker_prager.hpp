#pragma once
// Sand: an elastic solid that holds no tension and slides where the shear stress exceeds its friction.

#include <cmath>

#include "material/laws/hencky.hpp"

namespace bulkley {

/// Drucker-Prager plasticity on Hencky elasticity (Klar et al. 2016), with dev e the deviatoric and e_v the volumetric elastic
/// strain:
///
///   e_v >= e_c:  the grains have come apart: no shear stress, e_v = e_c (the tip of the cone, e_c = cohesion / (kappa tan phi))
///   else:        2 mu ||dev e|| <= -3 alpha kappa (e_v - e_c),  alpha = sqrt(2/3) 2 sin phi / (3 - sin phi);
///                what exceeds it is taken from dev e, at constant volume
///
/// J is the ratio of all volume, elastic and plastic. Volume that was gained at the tip must be lost again before the grains
/// touch: e_v = min(e_c, ln J). This is the volume correction of Tampubolon et al. (2017), whose accumulated scalar is the
/// difference of ln J and e_v, without a variable of its own.
///
/// Hardening (Klar et al. 2016): phi = friction_angle + (hardening_rise q - hardening_drop) exp(-hardening_decay q), in degrees,
/// with q the accumulated deviatoric plastic strain. (Klar et al. also count the volume gained at the tip.)
struct DruckerPrager {
  struct Parameters : NeoHookean::Parameters {
    double friction_angle = std::numeric_limits<double>::quiet_NaN();  ///< phi, degrees, above 0 to 60
    double cohesion = 0.0;                                             ///< Pa, >= 0: shear stress held without pressure
    double hardening_rise = 0.0;                                       ///< h1, degrees, >= 0
    double hardening_decay = 0.2;                                      ///< h2, >= 0
    double hardening_drop = 0.0;                                       ///< h3, degrees, 0 to below friction_angle
  };
  Parameters parameters;

  static constexpr const char* law_name = "drucker_prager";
  static constexpr bool flows = true;
  static constexpr std::array internal{Field::hardening};
  std::array<double, 1> initial_internal() const { return {0.0}; }

  double density() const { return parameters.density; }
  double viscosity() const { return 0.0; }
  Hencky elastic() const { return {parameters}; }

  static constexpr double radians_per_degree = 0.017453292519943295;

  /// e_c, the volumetric strain of the tip.
  double tip_strain() const {
    return parameters.cohesion / (parameters.bulk_modulus * std::tan(radians_per_degree * parameters.friction_angle));
  }

  /// alpha from sin phi.
  template <class Real>
  static Real cone_slope(Real sine) {
    return 0.81649658092772603 * 2.0 * sine / (3.0 - sine);
  }
  double cone_slope_at_rest() const { return cone_slope(std::sin(radians_per_degree * parameters.friction_angle)); }

  template <class Real>
  Real cone_slope_after(Real hardening) const {
    const Parameters& p = parameters;
    if (p.hardening_rise == 0.0 && p.hardening_drop == 0.0) return broadcast<Real>(cone_slope_at_rest());
    const Real degrees =
        p.friction_angle + (p.hardening_rise * hardening - p.hardening_drop) * exponential(-p.hardening_decay * hardening);
    return cone_slope(sine(radians_per_degree * degrees));
  }

  /// The stress of an elastic state that the plastic flow has left on or inside the cone.
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real, 1>& state) const {
    const Real volumetric = minimum(logarithm(state.volume_ratio), broadcast<Real>(tip_strain()));
    return elastic().kirchhoff_stress(log_strain(state.left_cauchy_green), broadcast<Real>(1.0), volumetric);
  }
  template <class Real>
  Real wave_speed_squared(const State<Real, 1>& state) const {
    const Real volumetric = minimum(logarithm(state.volume_ratio), broadcast<Real>(tip_strain()));
    return elastic().wave_speed_squared(state.left_cauchy_green, volumetric);
  }
  /// Beyond the tip the stress stays kappa e_c, and its work is given back when the volume returns: W grows linearly there.
  template <class Real>
  Real energy_density(const State<Real, 1>& state) const {
    const Real total = logarithm(state.volume_ratio);
    const Real volumetric = minimum(total, broadcast<Real>(tip_strain()));
    return parameters.shear_modulus * log_strain(state.left_cauchy_green).norm_squared() +
           parameters.bulk_modulus * (volumetric * (total - 0.5 * volumetric));
  }

  /// What of dev e remains after the return to the cone, and the plastic strain of the step.
  template <class Real>
  struct Return {
    Real ratio;           ///< of dev e to its trial value, 0 to 1
    Real plastic_strain;  ///< the norm of what was taken away
  };
  /// `norm`: ||dev e|| of the trial; `volumetric`: ln J.
  template <class Real>
  Return<Real> return_to_cone(Real norm, Real volumetric, Real slope) const {
    const Real zero = broadcast<Real>(0.0);
    const double stiffness = 1.5 * parameters.bulk_modulus / parameters.shear_modulus;
    const Real depth = volumetric - tip_strain();
    const Real allowed = maximum(zero, -stiffness * depth * slope);
    const Real excess = maximum(zero, norm - allowed);
    const Mask<Real> slides = excess > zero;
    return {select(slides, allowed / select(slides, norm, broadcast<Real>(1.0)), broadcast<Real>(1.0)), excess};
  }

  /// See law.hpp. The rate reported is sqrt(2) times the deviatoric plastic strain rate; dissipation is the stress after the
  /// return times the plastic strain, 2 mu ||dev e|| ||plastic strain||. Requires det(1 + dt L) > 0.
  template <class Real>
  Update<Real> update(State<Real, 1>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    deform(static_cast<State<Real>&>(state), velocity_gradient, dt);
    Real& hardening = state.internal[0];
    const Real total = logarithm(state.volume_ratio);
    const LogStrain<Real> trial = log_strain(state.left_cauchy_green);
    const Real squared = trial.norm_squared(), norm = square_root(squared);
    const Return<Real> back = return_to_cone(norm, total, cone_slope_after(hardening));
    const Mask<Real> slides = back.ratio < broadcast<Real>(1.0);
    if (any(slides)) {
      const SymTensor<Real> b = left_cauchy_green_of(trial, back.ratio);
      for (int c = 0; c < 6; ++c) state.left_cauchy_green.c[c] = select(slides, b.c[c], state.left_cauchy_green.c[c]);
    }
    hardening += back.plastic_strain;
    const Real volumetric = minimum(total, broadcast<Real>(tip_strain()));
    return {elastic().kirchhoff_stress(trial, back.ratio, volumetric), back.plastic_strain * (std::sqrt(2.0) / dt),
            (2.0 * parameters.shear_modulus) * ((norm * back.ratio) * back.plastic_strain)};
  }

 private:
  /// sin x for |x| < 1.2, below 1e-15 off: Taylor's series.
  template <class Real>
  static Real sine(Real x) {
    const Real z = x * x;
    Real term = x, sum = x;
    for (int k = 1; k < 10; ++k) {
      term = term * z * (-1.0 / (2.0 * k * (2.0 * k + 1.0)));
      sum += term;
    }
    return sum;
  }
};

/// What is wrong with parameters that are within the ranges of their keys, as one sentence; empty when nothing is. Not collective.
std::optional<std::string> parameter_fault(const DruckerPrager::Parameters& parameters);

}  // namespace bulkley
