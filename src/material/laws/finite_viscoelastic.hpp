#pragma once
// Viscoelastic solid of two branches: an elastic one, and one whose strain relaxes.

#include "material/laws/hencky.hpp"

namespace bulkley {

/// tau = tau_elastic(F) + tau_branch(F_e): a neo-Hookean branch that holds at rest, and a Hencky branch F = F_e F_v whose
/// strain e relaxes by de/dt = -dev e / t_s - (tr e / 3) 1 / t_v (Reese & Govindjee 1998; Fang et al. 2019, section 4, whose
/// viscosities are nu_d = 2 mu_b t_s and nu_v = 2 kappa_b t_v). Backward Euler in e is exact in its algebra.
struct FiniteViscoelastic {
  struct Parameters : NeoHookean::Parameters {                               ///< of the elastic branch
    double branch_shear_modulus = std::numeric_limits<double>::quiet_NaN();  ///< mu_b, Pa, > 0
    double branch_bulk_modulus = 0.0;                                        ///< kappa_b, Pa, >= 0
    double relaxation_time = std::numeric_limits<double>::quiet_NaN();       ///< t_s of the branch's deviator, s, > 0
    double bulk_relaxation_time = std::numeric_limits<double>::infinity();   ///< t_v of its volume, s, > 0
  };
  Parameters parameters;

  static constexpr const char* law_name = "finite_viscoelastic";
  static constexpr bool flows = true;
  static constexpr std::array internal{Field::viscous_left_cauchy_green};
  std::array<double, 6> initial_internal() const { return {1.0, 1.0, 1.0, 0.0, 0.0, 0.0}; }

  double density() const { return parameters.density; }
  double viscosity() const { return 0.0; }
  VolumetricLaw volumetric() const { return {VolumetricLaw::Form::neo_hookean, parameters.bulk_modulus}; }
  NeoHookean elastic() const { return {parameters}; }
  Hencky branch() const { return {{parameters.density, parameters.branch_bulk_modulus, parameters.branch_shear_modulus}}; }

  /// The branch's own elastic state, from the internal variable F_e F_e^T.
  template <class Real>
  static State<Real> branch_state(const State<Real, 6>& state) {
    SymTensor<Real> b;
    for (int c = 0; c < 6; ++c) b.c[c] = state.internal[c];
    const Real squared = determinant(b), scale = inverse_cube_root(squared);
    for (Real& component : b.c) component *= scale;
    return {b, square_root(squared)};
  }

  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real, 6>& state) const {
    return sum(elastic().kirchhoff_stress(state), branch().kirchhoff_stress(branch_state(state)));
  }
  /// The bounds of both branches add.
  template <class Real>
  Real wave_speed_squared(const State<Real, 6>& state) const {
    return elastic().wave_speed_squared(state) + branch().wave_speed_squared(branch_state(state));
  }
  template <class Real>
  Real energy_density(const State<Real, 6>& state) const {
    return elastic().energy_density(state) + branch().energy_density(branch_state(state));
  }

  /// See law.hpp. The rate reported is that of the branch's viscous strain, sqrt(2) ||dev e|| / t_s; dissipation is its stress
  /// times that strain's growth. Requires det(1 + dt L) > 0.
  template <class Real>
  Update<Real> update(State<Real, 6>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    State<Real> relaxing = branch_state(state);
    deform(relaxing, velocity_gradient, dt);
    deform(static_cast<State<Real>&>(state), velocity_gradient, dt);
    LogStrain<Real> strain = log_strain(relaxing.left_cauchy_green);
    const Real factor = broadcast<Real>(1.0 / (1.0 + dt / parameters.relaxation_time));
    const Real volumetric = logarithm(relaxing.volume_ratio) * (1.0 / (1.0 + dt / parameters.bulk_relaxation_time));
    for (Real& value : strain.value) value *= factor;
    const Real one = broadcast<Real>(1.0);
    const SymTensor<Real> b = left_cauchy_green_of(strain, one);
    const Real squared = exponential((2.0 / 3.0) * volumetric);
    for (int c = 0; c < 6; ++c) state.internal[c] = squared * b.c[c];

    const Real shear = strain.norm_squared();
    const double mu = parameters.branch_shear_modulus, kappa = parameters.branch_bulk_modulus;
    const Real dissipation = (2.0 * mu * dt / parameters.relaxation_time) * shear +
                             (kappa * dt / parameters.bulk_relaxation_time) * (volumetric * volumetric);
    return {sum(elastic().kirchhoff_stress(state), branch().kirchhoff_stress(strain, one, volumetric)),
            square_root(2.0 * shear) * (1.0 / parameters.relaxation_time), dissipation};
  }

 private:
  template <class Real>
  static SymTensor<Real> sum(SymTensor<Real> a, const SymTensor<Real>& b) {
    for (int c = 0; c < 6; ++c) a.c[c] += b.c[c];
    return a;
  }
};

}  // namespace bulkley
