#pragma once
// Weakly compressible Newtonian fluid.

#include "material/laws/neo_hookean.hpp"
#include "material/viscous_stress.hpp"

namespace bulkley {

/// tau = -p J 1 + 2 eta J dev D with p = (kappa/n) (J^-n - 1): Tait's equation of state as Cole (1948) writes it, or, for
/// n = 1, a pressure linear in the density. Holds no shear strain: b stays 1.
struct Newtonian {
  struct Parameters {
    double density = std::numeric_limits<double>::quiet_NaN();       ///< kg/m^3, reference, > 0
    double bulk_modulus = std::numeric_limits<double>::quiet_NaN();  ///< kappa = rho_0 c_0^2, Pa, > 0
    double viscosity = std::numeric_limits<double>::quiet_NaN();     ///< eta, Pa s, >= 0
    double tait_exponent = 7.0;                                      ///< n, >= 1
    bool tension = true;                                             ///< false: where J > 1 the pressure is 0, not negative
  };
  Parameters parameters;

  static constexpr const char* law_name = "newtonian";
  static constexpr bool flows = true;
  static constexpr std::array<Field, 0> internal{};

  double density() const { return parameters.density; }
  double viscosity() const { return parameters.viscosity; }
  VolumetricLaw volumetric() const {
    return {VolumetricLaw::Form::tait, parameters.bulk_modulus, parameters.tait_exponent, parameters.tension};
  }
  CharacteristicStress characteristic_stress(double rate) const { return {parameters.viscosity * rate, 0.0}; }

  /// p, Pa.
  template <class Real>
  Real pressure(Real J) const {
    const double n = parameters.tait_exponent;
    const Real p = (parameters.bulk_modulus / n) * (power(J, broadcast<Real>(-n)) - 1.0);
    return parameters.tension ? p : maximum(p, broadcast<Real>(0.0));
  }

  template <class Real>
  SymTensor<Real> kirchhoff_stress(const State<Real>& state) const {
    const Real zero = broadcast<Real>(0.0), spherical = -pressure(state.volume_ratio) * state.volume_ratio;
    return {spherical, spherical, spherical, zero, zero, zero};
  }

  /// c^2 = (kappa / rho_0) J^(1 - n).
  template <class Real>
  Real wave_speed_squared(const State<Real>& state) const {
    return power(state.volume_ratio, broadcast<Real>(1.0 - parameters.tait_exponent)) *
           (parameters.bulk_modulus / parameters.density);
  }

  /// The integral of -p dJ from 1, J per m^3 of reference volume.
  template <class Real>
  Real energy_density(const State<Real>& state) const {
    const double n = parameters.tait_exponent;
    const Real J = parameters.tension ? state.volume_ratio : minimum(state.volume_ratio, broadcast<Real>(1.0));
    const Real expansion = n == 1.0 ? -logarithm(J) : (power(J, broadcast<Real>(1.0 - n)) - 1.0) * (1.0 / (n - 1.0));
    return (parameters.bulk_modulus / n) * (expansion + (J - 1.0));
  }

  /// See law.hpp. The shear rate is all of it: sqrt(2 dev D : dev D). Requires det(1 + dt L) > 0.
  template <class Real>
  Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    Tensor<Real> f;
    for (int c = 0; c < 9; ++c) f.c[c] = velocity_gradient.c[c] * dt;
    for (int a = 0; a < 3; ++a) f(a, a) += 1.0;
    state.volume_ratio *= determinant(f);
    state.left_cauchy_green = isochoric_identity<Real>();
    const Real rate = square_root(2.0 * norm_squared(shear_rate_tensor(velocity_gradient)));
    Update<Real> result{kirchhoff_stress(state), rate, broadcast<Real>(0.0)};
    if (parameters.viscosity > 0.0)
      add_viscous_stress(result, velocity_gradient, state.volume_ratio, parameters.viscosity, dt);
    return result;
  }
};

}  // namespace bulkley
