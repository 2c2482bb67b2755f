#pragma once
// A toy: an elastic solid that counts its steps.

#include "material/laws/neo_hookean.hpp"

namespace bulkley {

struct ToyLaw {
  struct Parameters {
    double density = std::numeric_limits<double>::quiet_NaN();       ///< kg/m^3, > 0
    double bulk_modulus = std::numeric_limits<double>::quiet_NaN();  ///< Pa, > 0
    double shear_modulus = 10.0;                                     ///< Pa, >= 0
  };
  Parameters parameters;

  static constexpr const char* law_name = "toy_law";
  static constexpr bool flows = false;
  static constexpr std::array internal{Field::hardening};
  std::array<double, 1> initial_internal() const { return {5.0}; }

  double density() const { return parameters.density; }
  double viscosity() const { return 0.0; }
  CharacteristicStress characteristic_stress(double rate) const { return {3.0 * rate, 0.0}; }
  NeoHookean elastic() const { return {{parameters.density, parameters.bulk_modulus, parameters.shear_modulus}}; }

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
  template <class Real>
  Update<Real> update(State<Real, 1>& state, const Tensor<Real>& velocity_gradient, double dt) const {
    state.internal[0] += 1.0;
    return elastic().update(state, velocity_gradient, dt);
  }
};

}  // namespace bulkley
