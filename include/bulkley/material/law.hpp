#pragma once
// The contract of a constitutive law.
//
// A law is a struct with a member `parameters` (SI) and pure templates on Real (double or Pack), so that one source serves
// the single material point and the vector kernel. With n = n_internal<Law>:
//
//   template <class Real> Update<Real> update(State<Real, n>& state, const Tensor<Real>& velocity_gradient, double dt) const;
//       Advances the state over dt (f = 1 + dt L) and returns the Kirchhoff stress at its end.
//       det f <= 0 is the caller's to refuse beforehand.
//   template <class Real> Real wave_speed_squared(const State<Real, n>& state) const;   m^2/s^2, a bound over directions
//   template <class Real> Real energy_density(const State<Real, n>& state) const;       J per m^3 of reference volume
//   template <class Real> SymTensor<Real> kirchhoff_stress(const State<Real, n>& state) const;   without viscous parts
//   double density() const;                                                          kg/m^3, reference
//   double viscosity() const;                                                        Pa s, of stress that follows the rate of
//                                                                                    deformation at once; 0: none
//   static constexpr const char* law_name;                                           as written in scenes
//   static constexpr bool flows;                                                     deforms irreversibly: reports rate, dissipation
//   static constexpr std::array<Field, ...> internal;                                fields that hold its variables in addition to b and J;
//   static constexpr int n_variables;                                                outside the library instead: how many, up to 8
//   std::array<double, n> initial_internal() const;                                  their values at the start, if n > 0
// and, where it has one:
//   CharacteristicStress characteristic_stress(double rate) const;                   Pa, of steady shear at a rate (1/s)
//
// The law supplies the speed and the viscosity that limit dt, so stress and time step cannot drift apart.

#include <array>

#include "bulkley/base/tensor.hpp"
#include "bulkley/particle/field.hpp"

namespace bulkley {

/// The most numbers that a law added by a program may keep in addition to b and J.
inline constexpr int n_added_law_variables = info(Field::added_law_variables).n_components;

/// How many numbers a law keeps in addition to b and J: the components of its fields, or what a law outside the library says.
template <class Law>
inline constexpr int n_internal = [] {
  if constexpr (requires { Law::n_variables; }) {
    return Law::n_variables;
  } else {
    int n = 0;
    for (const Field variable : Law::internal) n += info(variable).n_components;
    return n;
  }
}();

/// The state of a material point: elastic strain, and the internal variables in the order of the law.
template <class Real, int n = 0>
struct State;
template <class Real>
struct State<Real, 0> {
  SymTensor<Real> left_cauchy_green;  ///< isochoric, det = 1
  Real volume_ratio;                  ///< J
};
template <class Real, int n>
struct State : State<Real, 0> {
  Real internal[n];
};

template <class Real>
struct Update {
  SymTensor<Real> kirchhoff_stress;  ///< Pa
  Real plastic_shear_rate;           ///< sqrt(2) gamma, 1/s; 0 where elastic
  Real dissipation;  ///< J per m^3 of reference volume, in this step: the work that is neither given back nor stored
};

/// The shear stress of a fluid at a shear rate: what Reynolds and Bingham numbers are made of.
struct CharacteristicStress {
  double total;  ///< Pa
  double yield;  ///< what of it is yield stress, Pa
};

/// Undeformed, with the internal variables of the start. Not collective.
template <class Law>
State<double, n_internal<Law>> state_at_rest(const Law& law) {
  State<double, n_internal<Law>> state;
  state.left_cauchy_green = {1.0, 1.0, 1.0, 0.0, 0.0, 0.0};
  state.volume_ratio = 1.0;
  if constexpr (n_internal < Law >> 0) {
    const auto initial = law.initial_internal();
    for (std::size_t k = 0; k < initial.size(); ++k) state.internal[k] = initial[k];
  }
  return state;
}

}  // namespace bulkley
