#pragma once
// St. Venant-Kirchhoff solid in logarithmic (Hencky) strain.

#include "bulkley/base/spectral.hpp"
#include "material/laws/neo_hookean.hpp"

namespace bulkley {

/// Logarithms of the principal stretches of an isochoric b: traceless, in no order.
template <class Real>
struct LogStrain {
  Real value[3];
  Tensor<Real> axes;  ///< columns: principal directions

  Real norm_squared() const { return value[0] * value[0] + value[1] * value[1] + value[2] * value[2]; }
};

/// (1/2) ln b for det b = 1; the trace that rounding leaves is taken out. Not collective.
template <class Real>
inline LogStrain<Real> log_strain(const SymTensor<Real>& b) {
  const Spectrum<Real> s = spectrum(b);
  LogStrain<Real> strain{{}, s.axes};
  for (int k = 0; k < 3; ++k) strain.value[k] = 0.5 * logarithm(s.value[k]);
  const Real mean = (strain.value[0] + strain.value[1] + strain.value[2]) * (1.0 / 3.0);
  for (Real& value : strain.value) value -= mean;
  return strain;
}

/// b = exp(2 factor strain). Not collective.
template <class Real>
inline SymTensor<Real> left_cauchy_green_of(const LogStrain<Real>& strain, Real factor) {
  Real squared[3];
  for (int k = 0; k < 3; ++k) squared[k] = exponential((2.0 * factor) * strain.value[k]);
  return from_spectrum(squared, strain.axes);
}

/// W = mu ||dev e||^2 + (kappa/2) (tr e)^2 with e = ln V, V^2 = F F^T (Hencky 1928; the elasticity of Klar et al. 2016).
/// Follows compression better than the neo-Hookean solid, but softens in strong extension: the force falls
/// beyond a stretch of e.
struct Hencky {
  using Parameters = NeoHookean::Parameters;
  Parameters parameters;

  static constexpr const char* law_name = "hencky";
  static constexpr bool flows = false;
  static constexpr std::array<Field, 0> internal{};

  double density() const { return parameters.density; }
  double viscosity() const { return 0.0; }
  VolumetricLaw volumetric() const { return {VolumetricLaw::Form::hencky, parameters.bulk_modulus}; }

  /// tau = 2 mu dev e + kappa tr e 1, Pa, from dev e scaled by `factor` and tr e.
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const LogStrain<Real>& strain, Real factor, Real volumetric) const {
    Real tau[3];
    for (int k = 0; k < 3; ++k)
      tau[k] = (2.0 * parameters.shear_modulus) * (factor * strain.value[k]) + parameters.bulk_modulus * volumetric;
    return from_spectrum(tau, strain.axes);
  }
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    return kirchhoff_stress(log_strain(state.left_cauchy_green), broadcast<Real>(1.0), logarithm(state.volume_ratio));
  }

  /// rho_0 c^2 <= kappa + (4/3) mu + max(0, -kappa ln J) + 6 mu e_max, e_max the largest principal strain: along principal
  /// axes rho_0 c^2 is kappa + (4/3) mu - tau_k for longitudinal waves and mu x / (1 - exp(-x)), x = 2 (e_i - e_j), for
  /// transverse ones.
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    return wave_speed_squared(state.left_cauchy_green, logarithm(state.volume_ratio));
  }
  template <class Real>
  Real wave_speed_squared(const SymTensor<Real>& b, Real volumetric) const {
    const double kappa = parameters.bulk_modulus, mu = parameters.shear_modulus;
    const Real largest_strain = 0.5 * logarithm(largest_eigenvalue_bound(b));
    return (kappa + 4.0 / 3.0 * mu + maximum(broadcast<Real>(0.0), -kappa * volumetric) + (6.0 * mu) * largest_strain) *
           (1.0 / parameters.density);
  }

  /// W, J per m^3 of reference volume.
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    const Real volumetric = logarithm(state.volume_ratio);
    return parameters.shear_modulus * log_strain(state.left_cauchy_green).norm_squared() +
           (0.5 * parameters.bulk_modulus) * (volumetric * volumetric);
  }

  /// See law.hpp. Requires det(1 + dt L) > 0.
  template <class Real>
  Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    deform(state, velocity_gradient, dt);
    return {kirchhoff_stress(state), broadcast<Real>(0.0), broadcast<Real>(0.0)};
  }
};

}  // namespace bulkley
