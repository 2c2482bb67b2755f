#pragma once
// Snow: an elastic solid that yields beyond a critical stretch, hardens when packed and softens when torn.

#include "material/laws/fixed_corotated.hpp"

namespace bulkley {

/// Stomakhin et al. (2013): fixed corotated elasticity of F_e, whose principal stretches are held within [1 - critical
/// compression, 1 + critical_stretch]; moduli times exp(hardening (1 - J_p)), J_p = J / J_e clamped to [0.6, 20] in the
/// exponent only, so that J stays the product of its parts.
struct Snow {
  struct Parameters : NeoHookean::Parameters {                               ///< of fresh snow, J_p = 1
    double critical_compression = std::numeric_limits<double>::quiet_NaN();  ///< above 0 to below 1
    double critical_stretch = std::numeric_limits<double>::quiet_NaN();      ///< > 0
    double hardening = std::numeric_limits<double>::quiet_NaN();             ///< xi, >= 0
  };
  Parameters parameters;

  static constexpr const char* law_name = "snow";
  static constexpr bool flows = true;
  static constexpr std::array internal{Field::plastic_volume_ratio};
  std::array<double, 1> initial_internal() const { return {1.0}; }

  double density() const { return parameters.density; }
  double viscosity() const { return 0.0; }
  FixedCorotated elastic() const { return {parameters}; }

  /// exp(xi (1 - J_p))
  template <class Real>
  Real stiffening(Real plastic_volume_ratio) const {
    constexpr double most_packed = 0.6, most_torn = 20.0;
    const Real bounded = maximum(minimum(plastic_volume_ratio, broadcast<Real>(most_torn)), broadcast<Real>(most_packed));
    return exponential(parameters.hardening * (1.0 - bounded));
  }

  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real, 1>& state) const {
    const State<Real> e = elastic_state(state);
    return elastic().kirchhoff_stress(principal_stretches(e.left_cauchy_green, e.volume_ratio), e.volume_ratio,
                                      stiffening(state.internal[0]));
  }
  template <class Real>
  Real wave_speed_squared(const State<Real, 1>& state) const {
    return stiffening(state.internal[0]) * elastic().wave_speed_squared(elastic_state(state));
  }
  template <class Real>
  Real energy_density(const State<Real, 1>& state) const {
    return stiffening(state.internal[0]) * elastic().energy_density(elastic_state(state));
  }

  /// See law.hpp. The rate reported is sqrt(2) ||dev of the plastic logarithmic strain|| / dt; dissipation is
  /// flow_dissipation. Requires det(1 + dt L) > 0.
  template <class Real>
  Update<Real> update(State<Real, 1>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    const Real zero = broadcast<Real>(0.0), one = broadcast<Real>(1.0);
    deform(static_cast<State<Real>&>(state), velocity_gradient, dt);
    Real& plastic = state.internal[0];
    const Real before = plastic;
    const State<Real> trial = elastic_state(state);
    Stretches<Real> v = principal_stretches(trial.left_cauchy_green, trial.volume_ratio);
    Mask<Real> yields = zero > one;
    Real logarithms[3], J = one;
    for (int k = 0; k < 3; ++k) {
      const Real held = minimum(maximum(v.value[k], broadcast<Real>(1.0 - parameters.critical_compression)),
                                broadcast<Real>(1.0 + parameters.critical_stretch));
      yields = yields | (held < v.value[k]) | (held > v.value[k]);
      logarithms[k] = logarithm(v.value[k] / held);
      v.value[k] = held;
      J *= held;
    }
    J = select(yields, J, trial.volume_ratio);
    Real rate = zero, dissipation = zero;
    if (any(yields)) {
      const Real scale = inverse_cube_root(J);
      Real squared[3];
      for (int k = 0; k < 3; ++k) squared[k] = (scale * v.value[k]) * (scale * v.value[k]);
      const SymTensor<Real> b = from_spectrum(squared, v.axes);
      for (int c = 0; c < 6; ++c) state.left_cauchy_green.c[c] = select(yields, b.c[c], state.left_cauchy_green.c[c]);
      plastic = select(yields, state.volume_ratio / J, plastic);
      const Real mean = (logarithms[0] + logarithms[1] + logarithms[2]) * (1.0 / 3.0);
      Real sum = zero;
      for (const Real& value : logarithms) sum += (value - mean) * (value - mean);
      rate = select(yields, square_root(2.0 * sum) * (1.0 / dt), zero);
      dissipation = select(yields, flow_dissipation(v, J, logarithms, stiffening(before), stiffening(plastic)), zero);
    }
    return {elastic().kirchhoff_stress(v, J, stiffening(plastic)), rate, dissipation};
  }

  /// The stress after clamping times the plastic logarithmic strain, less the energy that hardening stores in the elastic
  /// strain (softening sets it free), J per m^3 of reference volume: what the energy lacks once the step is small. Negative
  /// where the clamped stretch is held against its stress, which this flow rule allows. `v`, `J`: elastic, at the end of the
  /// step. Apart from `update`, whose products shall not fuse with these.
  template <class Real>
  [[gnu::noinline]] Real flow_dissipation(const Stretches<Real>& v, Real J, const Real (&plastic_strain)[3],
                                          Real stiffening_before, Real stiffening_after) const {
    const double mu = parameters.shear_modulus, lambda = elastic().lambda();
    Real work = broadcast<Real>(0.0), sum = broadcast<Real>(0.0);
    for (int k = 0; k < 3; ++k) {
      const Real strain = v.value[k] - 1.0;
      work += ((2.0 * mu) * (strain * v.value[k]) + lambda * (J * (J - 1.0))) * plastic_strain[k];
      sum += strain * strain;
    }
    const Real energy = mu * sum + (0.5 * lambda) * ((J - 1.0) * (J - 1.0));
    return stiffening_after * work - (stiffening_after - stiffening_before) * energy;
  }

 private:
  /// The isochoric b, and J_e = J / J_p.
  template <class Real>
  static State<Real> elastic_state(const State<Real, 1>& state) {
    return {state.left_cauchy_green, state.volume_ratio / state.internal[0]};
  }
};

}  // namespace bulkley
