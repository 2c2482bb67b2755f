#pragma once
// A constitutive law of one's own: the fluid of Carreau (1972), whose viscosity falls from a plateau at rest to another at high
// rates. The contract is that of bulkley/material/law.hpp.

#include <bulkley/material/add_law.hpp>
#include "material/laws/newtonian.hpp"

/// tau = -p J 1 + 2 eta J dev D, with eta(rate) = eta_inf + (eta_0 - eta_inf) (1 + (lambda rate)^2)^((n - 1) / 2), the rate
/// sqrt(2 dev D : dev D), and the pressure of bulkley::Newtonian. Counts the shear that a particle has undergone.
struct Carreau {
  struct Parameters {
    double density = std::numeric_limits<double>::quiet_NaN();               ///< kg/m^3, > 0
    double bulk_modulus = std::numeric_limits<double>::quiet_NaN();          ///< Pa, > 0
    double zero_shear_viscosity = std::numeric_limits<double>::quiet_NaN();  ///< eta_0, Pa s, > 0
    double infinite_shear_viscosity = 0.0;                                   ///< eta_inf, Pa s, from 0 to eta_0
    double relaxation_time = std::numeric_limits<double>::quiet_NaN();       ///< lambda, s, >= 0
    double flow_index = std::numeric_limits<double>::quiet_NaN();            ///< n, above 0 and at most 1
  };
  Parameters parameters;

  static constexpr const char* law_name = "carreau";
  static constexpr bool flows = true;
  /// One number of its own: the shear that a particle has undergone, the first of the field `added_law_variables`.
  static constexpr int n_variables = 1;
  std::array<double, 1> initial_internal() const { return {0.0}; }

  double density() const { return parameters.density; }
  double viscosity() const { return parameters.zero_shear_viscosity; }  // the largest: it bounds the time step
  bulkley::CharacteristicStress characteristic_stress(double rate) const { return {viscosity_at(rate) * rate, 0.0}; }

  template <class Real>
  using State = bulkley::State<Real, 1>;

  /// eta, Pa s, at a shear rate (1/s).
  template <class Real>
  Real viscosity_at(Real rate) const {
    const Parameters& p = parameters;
    const Real reduced = p.relaxation_time * rate;
    return p.infinite_shear_viscosity +
           (p.zero_shear_viscosity - p.infinite_shear_viscosity) *
               bulkley::power(1.0 + reduced * reduced, bulkley::broadcast<Real>(0.5 * (p.flow_index - 1.0)));
  }

  template <class Real>
  bulkley::SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    return solvent().kirchhoff_stress(state);
  }
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    return solvent().wave_speed_squared(state);
  }
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    return solvent().energy_density(state);
  }

  template <class Real>
  bulkley::Update<Real> update(State<Real>& state, const bulkley::Tensor<Real>& velocity_gradient, double dt) const {
    bulkley::Update<Real> result = solvent().update(state, velocity_gradient, dt);
    const bulkley::SymTensor<Real> shear = bulkley::shear_rate_tensor(velocity_gradient);
    const Real rate = result.plastic_shear_rate;
    const Real factor = (2.0 * state.volume_ratio) * viscosity_at(rate);
    for (int c = 0; c < 6; ++c) result.kirchhoff_stress.c[c] += factor * shear.c[c];
    result.dissipation += factor * norm_squared(shear) * dt;
    state.internal[0] += rate * dt;
    return result;
  }

 private:
  /// What carries the pressure.
  bulkley::Newtonian solvent() const { return {{parameters.density, parameters.bulk_modulus, 0.0}}; }
};

/// What is wrong with the parameters, as one sentence; single keys are checked by their ranges below.
inline std::optional<std::string> parameter_fault(const Carreau::Parameters& p) {
  if (p.infinite_shear_viscosity > p.zero_shear_viscosity)
    return "infinite_shear_viscosity must not be above zero_shear_viscosity";
  return std::nullopt;
}

/// The keys of [materials.NAME] with law = "carreau". Parameters that start as NaN must be given.
template <>
struct bulkley::LawKeys<Carreau> : bulkley::PlainKeys<Carreau> {
  static const config::Keys<Input>& table() {
    using P = Carreau::Parameters;
    static const auto keys =
        config::Keys<P>("A fluid whose viscosity falls from one plateau to another (Carreau 1972).")
            .key(
                "density", &P::density,
                {.about = "Density at rest.", .unit = "kg/m^3", .range = config::above(0.0), .default_text = "**required**"})
            .key("bulk_modulus", &P::bulk_modulus,
                 {.about = "Resistance to a change of volume.",
                  .unit = "Pa",
                  .range = config::above(0.0),
                  .default_text = "**required**"})
            .key(
                "zero_shear_viscosity", &P::zero_shear_viscosity,
                {.about = "Viscosity at rest.", .unit = "Pa s", .range = config::above(0.0), .default_text = "**required**"})
            .key("infinite_shear_viscosity", &P::infinite_shear_viscosity,
                 {.about = "Viscosity at high rates.", .unit = "Pa s", .range = config::at_least(0.0)})
            .key("relaxation_time", &P::relaxation_time,
                 {.about = "Its inverse is the rate at which thinning begins.",
                  .unit = "s",
                  .range = config::at_least(0.0),
                  .default_text = "**required**"})
            .key("flow_index", &P::flow_index,
                 {.about = "Exponent of the thinning part; 1: Newtonian.",
                  .range = {.lower = 0.0, .upper = 1.0, .lower_excluded = true},
                  .default_text = "**required**"});
    return keys;
  }
};
