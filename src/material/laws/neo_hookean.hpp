#pragma once
// Compressible neo-Hookean solid, the elastic part of every law here.

#include <limits>
#include <optional>
#include <string>

#include "bulkley/base/pack_math.hpp"
#include "bulkley/material/law.hpp"
#include "material/volumetric_law.hpp"

namespace bulkley {

/// Advances the state as if elastic (T14): f = 1 + dt L, J <- J det f, b <- (det f)^(-2/3) f b f^T (det b stays 1).
/// Requires det f > 0; else the state becomes NaN. Not collective.
template <class Real>
inline void deform(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) {
  Tensor<Real> f;
  for (int c = 0; c < 9; ++c) f.c[c] = velocity_gradient.c[c] * dt;
  for (int a = 0; a < 3; ++a) f(a, a) += 1.0;
  const Real det_f = determinant(f);
  const Real scale = inverse_cube_root(det_f);
  SymTensor<Real>& b = state.left_cauchy_green;
  b = push_forward(f, b);
  for (Real& component : b.c) component *= scale * scale;
  state.volume_ratio *= det_f;
}

/// The undeformed b.
template <class Real>
inline SymTensor<Real> isochoric_identity() {
  const Real one = broadcast<Real>(1.0), zero = broadcast<Real>(0.0);
  return {one, one, one, zero, zero, zero};
}

/// An upper bound of the largest eigenvalue of b: tr b / 3 + sqrt(2/3) ||dev b||, sharp for one large eigenvalue. Not
/// collective.
template <class Real>
inline Real largest_eigenvalue_bound(const SymTensor<Real>& b) {
  constexpr double sqrt_two_thirds = 0.81649658092772603;
  return trace(b) * (1.0 / 3.0) + sqrt_two_thirds * square_root(norm_squared(deviator(b)));
}

/// (T15): W = (kappa/2) [(J^2 - 1)/2 - ln J] + (mu/2) (tr b - 3), with b the isochoric left Cauchy-Green tensor (Simo &
/// Hughes 1998, chapter 9; Yue et al. 2015, section 5).
struct NeoHookean {
  struct Parameters {
    double density = std::numeric_limits<double>::quiet_NaN();        ///< kg/m^3, reference, > 0
    double bulk_modulus = std::numeric_limits<double>::quiet_NaN();   ///< kappa, Pa, > 0
    double shear_modulus = std::numeric_limits<double>::quiet_NaN();  ///< mu, Pa, >= 0
  };
  Parameters parameters;

  static constexpr const char* law_name = "neo_hookean";
  static constexpr bool flows = false;
  static constexpr std::array<Field, 0> internal{};

  double density() const { return parameters.density; }
  double viscosity() const { return 0.0; }
  VolumetricLaw volumetric() const { return {VolumetricLaw::Form::neo_hookean, parameters.bulk_modulus}; }

  /// (T16): tau = (kappa/2) (J^2 - 1) 1 + mu dev b, Pa.
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    return kirchhoff_stress(deviator(state.left_cauchy_green), state.volume_ratio);
  }
  /// The same from e = dev b and J.
  template <class Real>
  SymTensor<Real> kirchhoff_stress(const SymTensor<Real>& e, Real J) const {
    SymTensor<Real> tau = e;
    for (Real& component : tau.c) component *= parameters.shear_modulus;
    const Real pressure_part = 0.5 * parameters.bulk_modulus * ((J - 1.0) * (J + 1.0));
    for (int a = 0; a < 3; ++a) tau.c[a] += pressure_part;
    return tau;
  }

  /// (T25): rho_0 c^2 = (kappa/2) (J^2 + 1) + (4/3) mu lambda_max(b): bounds every direction and polarisation, with the bound
  /// of lambda_max above.
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    const Real J = state.volume_ratio;
    const Real largest = largest_eigenvalue_bound(state.left_cauchy_green);
    return ((0.5 * parameters.bulk_modulus) * (J * J + 1.0) + (4.0 / 3.0 * parameters.shear_modulus) * largest) *
           (1.0 / parameters.density);
  }

  /// W, J per m^3 of reference volume.
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    const Real J = state.volume_ratio;
    return (0.5 * parameters.bulk_modulus) * (0.5 * ((J - 1.0) * (J + 1.0)) - logarithm(J)) +
           (0.5 * parameters.shear_modulus) * (trace(state.left_cauchy_green) - 3.0);
  }

  /// See law.hpp. Requires det(1 + dt L) > 0. Without shear stiffness (mu = 0) b stays 1: it has no effect there, and in a
  /// fluid it would grow until it overflows.
  template <class Real>
  Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    deform(state, velocity_gradient, dt);
    if (parameters.shear_modulus == 0.0) state.left_cauchy_green = isochoric_identity<Real>();
    return {kirchhoff_stress(state), broadcast<Real>(0.0), broadcast<Real>(0.0)};
  }
};

/// kappa = E / (3 (1 - 2 nu)) and mu = E / (2 (1 + nu)), from Young's modulus (Pa) and Poisson's ratio (-1 < nu < 1/2).
NeoHookean::Parameters from_youngs_modulus(double density, double youngs_modulus, double poisson_ratio);

}  // namespace bulkley
