#pragma once
// Herschel-Bulkley fluid: a neo-Hookean solid that flows above a yield stress.

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "magnetics/field_yield.hpp"
#include "material/laws/neo_hookean.hpp"
#include "material/layer_return.hpp"
#include "material/viscous_stress.hpp"

namespace bulkley {

/// What flow dissipates in a step that takes ||dev b|| from its trial value to the part `ratio` of it, J per m^3 of reference
/// volume (T23): mu (3/2) dx/d||e|| at the end of the step times (1 - ratio) ||dev b_trial||, with J2, J3 and the mean x of b
/// there. Apart from flow_step, whose products shall not fuse with these. Not collective.
template <class Real>
[[gnu::noinline]] Real flow_dissipation(double mu, Real trial_norm_squared, Real J2, Real J3, Real mean, Real ratio) {
  const Real zero = broadcast<Real>(0.0);
  const Real slope = ratio * mean * trial_norm_squared - 3.0 * J3 / maximum(ratio, broadcast<Real>(1e-100));
  const Real taken = maximum(zero, 1.0 - ratio);
  return maximum(zero, (1.5 * mu) * (taken * slope / (3.0 * (mean * mean) - J2)));
}

/// One step of a neo-Hookean solid that flows by `rule` (T19) to (T23): elastic trial; backward Euler on s (return_map.hpp);
/// the deviator scaled to the new s; the spherical part of b chosen such that det b = 1. The common alternative for the last
/// step, dividing b by (det b)^(1/3), would shrink s as well. The rule is one of the Cauchy stress, as a rheometer measures it: that of
/// the Kirchhoff stress would be 1/J times as strong, more where the modulus is lower. Dissipation (T23) is the elastic energy per
/// strain at the end of the step times the strain that the flow took away. `fall`, if given: for layers in which the stress falls by that
/// part of the yield stress, on either side (layer_return.hpp). Requires det(1 + dt L) > 0 and dt > 0. Not collective.
template <class Real, class Number>
inline Update<Real> flow_step(const NeoHookean& elastic, const FlowRule<Number>& rule, State<Real>& state,
                              const Tensor<Real>& velocity_gradient, double dt, const Real* fall) {
  const Real zero = broadcast<Real>(0.0);
  const double mu = elastic.parameters.shear_modulus;
  if (mu == 0.0) return elastic.update(state, velocity_gradient, dt);
  deform(state, velocity_gradient, dt);
  SymTensor<Real>& b = state.left_cauchy_green;
  const Real trial_mean = trace(b) * (1.0 / 3.0);
  SymTensor<Real> e = deviator(b);
  const Real trial_norm_squared = norm_squared(e);
  const Real per_volume = 1.0 / state.volume_ratio;
  const Real trial_norm = (mu * per_volume) * square_root(trial_norm_squared), mean_per_volume = trial_mean * per_volume;
  FlowReturn<Real> flow{};
  if (!fall || any(*fall <= zero)) flow = flow_return(trial_norm, mu, mean_per_volume, dt, rule);
  if (fall && any(*fall > zero)) flow = layer_return(flow, trial_norm, mu, mean_per_volume, dt, rule, *fall);
  Real dissipation = zero;
  if (any(flow.yields)) {
    const Real ratio_squared = flow.ratio * flow.ratio;
    const Real J2 = 0.5 * trial_norm_squared * ratio_squared;
    const Real J3 = determinant(e) * (flow.ratio * ratio_squared);
    const Real mean = isochoric_mean(J2, J3, trial_mean, flow.yields);
    for (Real& component : e.c) component *= flow.ratio;  // 1 where elastic
    for (int c = 0; c < 6; ++c) b.c[c] = c < 3 ? select(flow.yields, e.c[c] + mean, b.c[c]) : e.c[c];
    dissipation = select(flow.yields, flow_dissipation(mu, trial_norm_squared, J2, J3, mean, flow.ratio), zero);
  }
  return {elastic.kirchhoff_stress(e, state.volume_ratio), std::sqrt(2.0) * flow.rate, dissipation};
}

/// The constants that a shear rheometer reports: tau = yield_stress + consistency * shear_rate^flow_index.
struct ShearRheometerConstants {
  double yield_stress = std::numeric_limits<double>::quiet_NaN();  ///< tau_y, Pa
  double consistency = std::numeric_limits<double>::quiet_NaN();   ///< K, Pa s^n
  double flow_index = std::numeric_limits<double>::quiet_NaN();    ///< n = h
};

/// Viscoplastic flow of Yue et al. 2015, section 5: with s = ||dev sigma||, gamma = (max(0, s - sqrt(2/3) sigma_Y) /
/// eta)^(1/h); in addition to it, if wanted, the Newtonian stress of a background fluid.
struct HerschelBulkley {
  struct Parameters {
    double density = std::numeric_limits<double>::quiet_NaN();        ///< kg/m^3, reference, > 0
    double bulk_modulus = std::numeric_limits<double>::quiet_NaN();   ///< kappa, Pa, > 0
    double shear_modulus = std::numeric_limits<double>::quiet_NaN();  ///< mu, Pa, >= 0
    double sigma_Y = std::numeric_limits<double>::quiet_NaN();        ///< yield stress, Pa, >= 0, von Mises convention
    double eta = std::numeric_limits<double>::quiet_NaN();            ///< Pa s^h, >= 0; 0: plastic, infinity: elastic
    double h = std::numeric_limits<double>::quiet_NaN();              ///< flow index, 0.1 to 3; < 1 shear thinning
    double background_viscosity = 0.0;                                ///< Pa s, >= 0
    ShearRheometerConstants given = {};  ///< the flow as a scene gave it, if it did in this convention: for writing it again
    FieldYield field_yield = {};         ///< what a magnetic field adds to the yield stress
  };
  Parameters parameters;
  /// Of eta and h as they were when the law was made; goes unused, at a loss of speed, once they have changed.
  std::shared_ptr<const OverstressTable> table = make_overstress_table(parameters.eta, parameters.h);

  static constexpr const char* law_name = "herschel_bulkley";
  static constexpr bool flows = true;
  static constexpr std::array<Field, 0> internal{};

  double density() const { return parameters.density; }
  double viscosity() const { return parameters.background_viscosity; }
  VolumetricLaw volumetric() const { return {VolumetricLaw::Form::neo_hookean, parameters.bulk_modulus}; }
  CharacteristicStress characteristic_stress(double rate) const { return characteristic_stress(parameters, rate); }
  static CharacteristicStress characteristic_stress(const Parameters& parameters, double rate);

  /// The elastic part.
  NeoHookean elastic() const { return {{parameters.density, parameters.bulk_modulus, parameters.shear_modulus}}; }

  /// The flow rule in the form of return_map.hpp.
  FlowRule<double> flow_rule() const {
    const bool fits = table && table->eta() == parameters.eta && table->h() == parameters.h;
    const double radius = std::sqrt(2.0 / 3.0) * parameters.sigma_Y;
    if (!fits) [[unlikely]]
      return {radius, parameters.eta, parameters.h};
    return {radius, parameters.eta, parameters.h, table.get(), table->log_eta()};
  }

  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    return elastic().kirchhoff_stress(state);
  }
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    return elastic().wave_speed_squared(state);
  }
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    return elastic().energy_density(state);
  }

  /// See law.hpp and flow_step. The background's stress is 2 background_viscosity J dev D.
  template <class Real>
  Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt, const Real* fall = nullptr) const {
    Update<Real> result = flow_step(elastic(), flow_rule(), state, velocity_gradient, dt, fall);
    if (parameters.background_viscosity > 0.0)
      add_viscous_stress(result, velocity_gradient, state.volume_ratio, parameters.background_viscosity, dt);
    return result;
  }

  /// The same in a magnetic field of the strength `field` (A/m), which differs from particle to particle.
  template <class Real>
  Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt, Real field,
                      const Real* fall = nullptr) const {
    const FlowRule<double> rest = flow_rule();
    const FlowRule<Real> rule{rest.radius + std::sqrt(2.0) * parameters.field_yield.at(field), broadcast<Real>(rest.eta),
                              rest.h, rest.table, broadcast<Real>(rest.log_eta)};
    Update<Real> result = flow_step(elastic(), rule, state, velocity_gradient, dt, fall);
    if (parameters.background_viscosity > 0.0)
      add_viscous_stress(result, velocity_gradient, state.volume_ratio, parameters.background_viscosity, dt);
    return result;
  }
};

/// (T24): tau_y = sigma_Y / sqrt(3), K = eta 2^(-(1+h)/2): steady simple shear at small elastic strain. Not collective.
ShearRheometerConstants shear_rheometer_constants(const HerschelBulkley::Parameters& parameters);

/// The inverse: fills sigma_Y = sqrt(3) tau_y, eta = K 2^((1+h)/2) and h, and leaves the rest alone. Not collective.
void set_flow(HerschelBulkley::Parameters& parameters, const ShearRheometerConstants& constants);

/// Whether the flow is still what `given` says, bit for bit, so that the scene may be written with it. Not collective.
bool is_as_given(const HerschelBulkley::Parameters& parameters);

}  // namespace bulkley
