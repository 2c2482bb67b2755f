#pragma once
// Viscoelastic fluid of the Oldroyd-B kind: a polymer that relaxes, in a Newtonian solvent.

#include "material/laws/neo_hookean.hpp"
#include "material/viscous_stress.hpp"

namespace bulkley {

/// tau = (kappa/2) (J^2 - 1) 1 + G dev b + 2 eta_s J dev D, where b relaxes towards 1 in the time lambda.
///
/// `upper_convected`: b is the conformation tensor of Oldroyd (1950), db/dt = l b + b l^T - (b - 1) / lambda with l = dev L, here
/// convected without the change of volume, which J holds; det b is free. Steady shear: tau_12 = (eta_s + G lambda) rate,
/// N1 = 2 G (lambda rate)^2.
/// `isochoric`: the same, and b is scaled to det b = 1 after every step (Ram et al. 2015). Elastic strain cannot grow as far:
/// the shear stress saturates where lambda rate approaches 1, and both agree only well below.
struct OldroydB {
  enum class Form { upper_convected, isochoric };
  struct Parameters {
    double density = std::numeric_limits<double>::quiet_NaN();          ///< kg/m^3, reference, > 0
    double bulk_modulus = std::numeric_limits<double>::quiet_NaN();     ///< kappa, Pa, > 0
    double shear_modulus = std::numeric_limits<double>::quiet_NaN();    ///< G, Pa, > 0
    double relaxation_time = std::numeric_limits<double>::quiet_NaN();  ///< lambda, s, > 0
    double solvent_viscosity = 0.0;                                     ///< eta_s, Pa s, >= 0
    Form form = Form::upper_convected;
  };
  Parameters parameters;

  static constexpr const char* law_name = "oldroyd_b";
  static constexpr bool flows = true;
  static constexpr std::array<Field, 0> internal{};

  double density() const { return parameters.density; }
  double viscosity() const { return parameters.solvent_viscosity; }
  VolumetricLaw volumetric() const { return {VolumetricLaw::Form::neo_hookean, parameters.bulk_modulus}; }
  CharacteristicStress characteristic_stress(double rate) const {
    const Parameters& p = parameters;
    return {(p.solvent_viscosity + p.shear_modulus * p.relaxation_time) * rate, 0.0};
  }

  /// kappa and G as those of a solid: the stress and wave speed of b, and its energy up to the ln det b of a free b.
  NeoHookean elastic() const { return {{parameters.density, parameters.bulk_modulus, parameters.shear_modulus}}; }

  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    return elastic().kirchhoff_stress(state);
  }
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    return elastic().wave_speed_squared(state);
  }
  /// The neo-Hookean W less (G/2) ln det b, which is 0 in the isochoric form.
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    const Real energy = elastic().energy_density(state);
    if (parameters.form == Form::isochoric) return energy;
    return energy - (0.5 * parameters.shear_modulus) * logarithm(determinant(state.left_cauchy_green));
  }

  /// The rate at which relaxation takes elastic energy, W per m^3 of reference volume: (G / (2 lambda)) (tr b + tr b^-1 - 6),
  /// in the isochoric form (G / (2 lambda)) (tr b tr b^-1 / 3 - 3). Apart from `update`, whose products shall not fuse with
  /// these.
  template <class Real>
  [[gnu::noinline]] Real relaxation_power(const SymTensor<Real>& b) const {
    const Real sum = trace(b), inverse_sum = 0.5 * (sum * sum - norm_squared(b)) / determinant(b);
    const Real excess = parameters.form == Form::isochoric ? sum * inverse_sum * (1.0 / 3.0) - 3.0 : sum + inverse_sum - 6.0;
    return (0.5 * parameters.shear_modulus / parameters.relaxation_time) * maximum(excess, broadcast<Real>(0.0));
  }

  /// See law.hpp: b_tr = f b f^T (det f)^(-2/3); backward Euler b = (b_tr + (dt / lambda) 1) / (1 + dt / lambda); scaled, if
  /// isochoric. Dissipation: see relaxation_power. The rate reported is that of the relaxation,
  /// ||dev b_tr - dev b|| / (sqrt(2) dt): in steady shear with small elastic strain the shear rate. Requires
  /// det(1 + dt L) > 0.
  template <class Real>
  Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    deform(state, velocity_gradient, dt);
    SymTensor<Real>& b = state.left_cauchy_green;
    const SymTensor<Real> trial = b;
    const double part = dt / parameters.relaxation_time, scale = 1.0 / (1.0 + part);
    for (int c = 0; c < 6; ++c) b.c[c] = (b.c[c] + (c < 3 ? part : 0.0)) * scale;
    if (parameters.form == Form::isochoric) {
      const Real factor = inverse_cube_root(determinant(b));
      for (Real& component : b.c) component *= factor;
    }
    SymTensor<Real> relaxed;
    for (int c = 0; c < 6; ++c) relaxed.c[c] = trial.c[c] - b.c[c];
    const Real rate = square_root(0.5 * norm_squared(deviator(relaxed))) * (1.0 / dt);
    Update<Real> result{kirchhoff_stress(state), rate, relaxation_power(b) * dt};
    if (parameters.solvent_viscosity > 0.0)
      add_viscous_stress(result, velocity_gradient, state.volume_ratio, parameters.solvent_viscosity, dt);
    return result;
  }
};

}  // namespace bulkley
