#pragma once
// A constitutive law of one's own: the fluid of Carreau (1972), whose viscosity falls from a plateau at rest to another at high
// rates. The contract is that of bulkley/material/law.hpp.

#include <bulkley/base/pack_math.hpp>
#include <bulkley/material/add_law.hpp>

#include <limits>

/// tau = -p J 1 + 2 eta J dev D, with eta(rate) = eta_inf + (eta_0 - eta_inf) (1 + (lambda rate)^2)^((n - 1) / 2), the rate
/// sqrt(2 dev D : dev D), and p = (kappa/7) (J^-7 - 1) (Cole 1948). Counts the shear that a particle has undergone.
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

  /// -p J 1
  template <class Real>
  bulkley::SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    const Real zero = bulkley::broadcast<Real>(0.0), J = state.volume_ratio;
    const Real spherical = (parameters.bulk_modulus / tait) * (1.0 - bulkley::power(J, bulkley::broadcast<Real>(-tait))) * J;
    return {spherical, spherical, spherical, zero, zero, zero};
  }
  /// c^2 = (kappa / rho_0) J^-6
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    return bulkley::power(state.volume_ratio, bulkley::broadcast<Real>(1.0 - tait)) *
           (parameters.bulk_modulus / parameters.density);
  }
  /// The integral of -p dJ from 1.
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    const Real J = state.volume_ratio;
    const Real expansion = (bulkley::power(J, bulkley::broadcast<Real>(1.0 - tait)) - 1.0) * (1.0 / (tait - 1.0));
    return (parameters.bulk_modulus / tait) * (expansion + (J - 1.0));
  }

  template <class Real>
  bulkley::Update<Real> update(State<Real>& state, const bulkley::Tensor<Real>& velocity_gradient, double dt) const {
    const bulkley::Tensor<Real>& L = velocity_gradient;
    bulkley::Tensor<Real> f;
    for (int c = 0; c < 9; ++c) f.c[c] = L.c[c] * dt;
    for (int a = 0; a < 3; ++a) f(a, a) += 1.0;
    state.volume_ratio *= determinant(f);  // b stays 1: a fluid holds no shear strain

    const bulkley::SymTensor<Real> rate_of_deformation{
        L(0, 0), L(1, 1), L(2, 2), 0.5 * (L(0, 1) + L(1, 0)), 0.5 * (L(1, 2) + L(2, 1)), 0.5 * (L(0, 2) + L(2, 0))};
    const bulkley::SymTensor<Real> shear = deviator(rate_of_deformation);
    const Real rate = bulkley::square_root(2.0 * norm_squared(shear));
    const Real factor = (2.0 * state.volume_ratio) * viscosity_at(rate);
    bulkley::Update<Real> result{kirchhoff_stress(state), rate, factor * norm_squared(shear) * dt};
    for (int c = 0; c < 6; ++c) result.kirchhoff_stress.c[c] += factor * shear.c[c];
    state.internal[0] += rate * dt;
    return result;
  }

 private:
  static constexpr double tait = 7.0;
};

/// What is wrong with parameters that are within the ranges of their keys below, as one sentence.
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
