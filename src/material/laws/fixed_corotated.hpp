#pragma once
// Fixed corotated elastic solid.

#include "bulkley/base/spectral.hpp"
#include "material/laws/neo_hookean.hpp"

namespace bulkley {

/// Principal stretches and directions.
template <class Real>
struct Stretches {
  Real value[3];
  Tensor<Real> axes;  ///< columns: principal directions
};

/// Of V, V^2 = J^(2/3) b for an isochoric b. Not collective.
template <class Real>
inline Stretches<Real> principal_stretches(const SymTensor<Real>& b, Real J) {
  const Spectrum<Real> s = spectrum(b);
  const Real scale = 1.0 / inverse_cube_root(J);
  Stretches<Real> stretches{{}, s.axes};
  for (int k = 0; k < 3; ++k) stretches.value[k] = scale * square_root(s.value[k]);
  return stretches;
}

/// W = mu ||F - R||^2 + (lambda/2) (J - 1)^2, F = R S = V R (Stomakhin et al. 2012). No rotation is needed: the stress follows
/// from V.
struct FixedCorotated {
  using Parameters = NeoHookean::Parameters;
  Parameters parameters;

  static constexpr const char* law_name = "fixed_corotated";
  static constexpr bool flows = false;
  static constexpr std::array<Field, 0> internal{};

  double density() const { return parameters.density; }
  double viscosity() const { return 0.0; }
  /// Lame's first parameter, Pa.
  double lambda() const { return parameters.bulk_modulus - 2.0 / 3.0 * parameters.shear_modulus; }

  /// tau = 2 mu (V^2 - V) + lambda J (J - 1) 1, Pa, with the moduli times `stiffening`.
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const Stretches<Real>& v, Real J, Real stiffening) const {
    Real tau[3];
    for (int k = 0; k < 3; ++k)
      tau[k] =
          stiffening * ((2.0 * parameters.shear_modulus) * ((v.value[k] - 1.0) * v.value[k]) + lambda() * (J * (J - 1.0)));
    return from_spectrum(tau, v.axes);
  }
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    return kirchhoff_stress(principal_stretches(state.left_cauchy_green, state.volume_ratio), state.volume_ratio,
                            broadcast<Real>(1.0));
  }

  /// rho_0 c^2 <= 2 mu V_max^2 + max(0, lambda) J^2: along principal axes, longitudinal waves have 2 mu V_k^2 + lambda J^2,
  /// transverse ones 2 mu V_i^2 (1 - 1 / (V_i + V_j)).
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    const Real J = state.volume_ratio;
    const Real squared = J * inverse_cube_root(J) * largest_eigenvalue_bound(state.left_cauchy_green);
    return ((2.0 * parameters.shear_modulus) * squared + maximum(broadcast<Real>(0.0), lambda() * (J * J))) *
           (1.0 / parameters.density);
  }

  /// W, J per m^3 of reference volume.
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    const Real J = state.volume_ratio;
    const Stretches<Real> v = principal_stretches(state.left_cauchy_green, J);
    Real sum = broadcast<Real>(0.0);
    for (const Real& stretch : v.value) sum += (stretch - 1.0) * (stretch - 1.0);
    return parameters.shear_modulus * sum + (0.5 * lambda()) * ((J - 1.0) * (J - 1.0));
  }

  /// See law.hpp. Requires det(1 + dt L) > 0.
  template <class Real>
  Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    deform(state, velocity_gradient, dt);
    return {kirchhoff_stress(state), broadcast<Real>(0.0), broadcast<Real>(0.0)};
  }
};

}  // namespace bulkley
