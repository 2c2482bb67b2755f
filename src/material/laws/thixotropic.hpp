#pragma once
// Herschel-Bulkley fluid whose yield stress and consistency depend on a structure that flow breaks down or builds up.

#include "material/laws/herschel_bulkley.hpp"

namespace bulkley {

/// A scalar structure lambda in [0, 1] (Houska 1981; Mewis & Wagner 2009) modulates the flow of Yue et al. (2015):
///
///   sigma_Y(lambda) = sigma_Y (r_Y + (1 - r_Y) lambda^m_Y),   eta(lambda) = eta (r_e + (1 - r_e) lambda^m_e)
///   thixotropic:  dlambda/dt = k_b (1 - lambda) - k_d rate^c lambda      flow breaks it down, rest builds it up
///   rheopectic:   dlambda/dt = k_b rate^c (1 - lambda) - k_d lambda      flow builds it up, rest breaks it down
///
/// with rate = sqrt(2) gamma, the plastic shear rate. Steady thixotropic flow has lambda = 1 / (1 + (k_d / k_b) rate^c).
/// Where the steady stress falls with the rate, homogeneous flow is unstable and shear bands form.
struct ThixotropicHerschelBulkley {
  enum class Kinetics { thixotropic, rheopectic };
  struct Parameters : HerschelBulkley::Parameters {  ///< of the full structure, lambda = 1
    Kinetics kinetics = Kinetics::thixotropic;
    double build_up = std::numeric_limits<double>::quiet_NaN();   ///< k_b, 1/s (rheopectic: s^(c-1)), >= 0
    double breakdown = std::numeric_limits<double>::quiet_NaN();  ///< k_d, s^(c-1) (rheopectic: 1/s), >= 0
    double rate_exponent = 1.0;                                   ///< c, > 0
    double yield_exponent = 1.0;                                  ///< m_Y, >= 0
    double consistency_exponent = 1.0;                            ///< m_e, >= 0
    double residual_yield = 0.0;                                  ///< r_Y, 0 to 1: yield stress at lambda = 0 over that at 1
    double residual_consistency = 0.0;                            ///< r_e, 0 to 1: the same for the consistency
    double initial_structure = 1.0;                               ///< lambda at the start, 0 to 1
  };
  Parameters parameters;
  /// The first guess of the flow rule's root depends on h alone.
  std::shared_ptr<const OverstressTable> table = make_overstress_table(1.0, parameters.h);

  static constexpr const char* law_name = "thixotropic_herschel_bulkley";
  static constexpr bool flows = true;
  static constexpr std::array internal{Field::structure};
  std::array<double, 1> initial_internal() const { return {parameters.initial_structure}; }

  double density() const { return parameters.density; }
  double viscosity() const { return parameters.background_viscosity; }
  VolumetricLaw volumetric() const { return {VolumetricLaw::Form::neo_hookean, parameters.bulk_modulus}; }
  /// Of the full structure.
  CharacteristicStress characteristic_stress(double rate) const {
    return HerschelBulkley::characteristic_stress(parameters, rate);
  }
  NeoHookean elastic() const { return {{parameters.density, parameters.bulk_modulus, parameters.shear_modulus}}; }

  /// residual + (1 - residual) lambda^exponent
  template <class Real>
  static Real strength(Real structure, double exponent, double residual) {
    const Real part = exponent == 0.0   ? broadcast<Real>(1.0)
                      : exponent == 1.0 ? structure
                                        : select(structure > broadcast<Real>(0.0),
                                                 power(structure, broadcast<Real>(exponent)), broadcast<Real>(0.0));
    return residual + (1.0 - residual) * part;
  }

  /// lambda after dt at a constant shear rate: lambda_eq + (lambda - lambda_eq) exp(-R dt) with R the sum of both
  /// coefficients and lambda_eq the share of the build-up; exact, and never outside [0, 1].
  template <class Real>
  Real next_structure(Real structure, Real rate, double dt) const {
    const Real zero = broadcast<Real>(0.0);
    const Parameters& p = parameters;
    const Real rate_power =
        p.rate_exponent == 1.0 ? rate : select(rate > zero, power(rate, broadcast<Real>(p.rate_exponent)), zero);
    const bool breaks = p.kinetics == Kinetics::thixotropic;
    const Real build = breaks ? broadcast<Real>(p.build_up) : p.build_up * rate_power;
    const Real sum = build + (breaks ? p.breakdown * rate_power : broadcast<Real>(p.breakdown));
    const Real equilibrium =
        select(sum > zero, build / maximum(sum, broadcast<Real>(std::numeric_limits<double>::min())), structure);
    return equilibrium + (structure - equilibrium) * exponential(-dt * sum);
  }

  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real, 1>& state) const {
    return elastic().kirchhoff_stress(state);
  }
  template <class Real>
  Real wave_speed_squared(const State<Real, 1>& state) const {
    return elastic().wave_speed_squared(state);
  }
  template <class Real>
  Real energy_density(const State<Real, 1>& state) const {
    return elastic().energy_density(state);
  }

  /// See law.hpp and flow_step: the stress with the structure of the step's start, then the structure with the step's shear
  /// rate (staggered, first order in dt).
  template <class Real>
  Update<Real> update(State<Real, 1>& state, const Tensor<Real>& velocity_gradient, double dt, const Real* fall = nullptr) const {
    const Parameters& p = parameters;
    const Real radius = (std::sqrt(2.0 / 3.0) * p.sigma_Y) * strength(state.internal[0], p.yield_exponent, p.residual_yield);
    return update_with(radius, state, velocity_gradient, dt, fall);
  }

  /// The same in a magnetic field of the strength `field` (A/m): its yield stress does not depend on the structure.
  template <class Real>
  Update<Real> update(State<Real, 1>& state, const Tensor<Real>& velocity_gradient, double dt, Real field,
                      const Real* fall = nullptr) const {
    const Parameters& p = parameters;
    const Real radius = (std::sqrt(2.0 / 3.0) * p.sigma_Y) * strength(state.internal[0], p.yield_exponent, p.residual_yield);
    return update_with(radius + std::sqrt(2.0) * p.field_yield.at(field), state, velocity_gradient, dt, fall);
  }

 private:
  /// With the yield radius `radius`, sqrt(2/3) sigma_Y, Pa.
  template <class Real>
  Update<Real> update_with(Real radius, State<Real, 1>& state, const Tensor<Real>& velocity_gradient, double dt, const Real* fall) const {
    const Parameters& p = parameters;
    Real& structure = state.internal[0];
    const Real eta = p.eta * strength(structure, p.consistency_exponent, p.residual_consistency);
    const FlowRule<Real> rule{radius, eta, p.h, table.get(), logarithm(eta)};
    Update<Real> result = flow_step(elastic(), rule, static_cast<State<Real>&>(state), velocity_gradient, dt, fall);
    structure = next_structure(structure, result.plastic_shear_rate, dt);
    if (p.background_viscosity > 0.0)
      add_viscous_stress(result, velocity_gradient, state.volume_ratio, p.background_viscosity, dt);
    return result;
  }
};

/// What is wrong with parameters that are within the ranges of their keys, as one sentence; empty when nothing is. Not collective.
std::optional<std::string> parameter_fault(const ThixotropicHerschelBulkley::Parameters& parameters);

}  // namespace bulkley
