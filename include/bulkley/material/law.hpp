#pragma once
// The contract of a constitutive law.
//
// A law is a struct with a member `parameters` (SI) and pure templates on Real (double or Pack), so that one source serves
// the single material point and the vector kernel:
//
//   template <class Real> Update<Real> update(State<Real>& state, const Tensor<Real>& velocity_gradient, double dt) const;
//       Advances the elastic state over dt (f = 1 + dt L) and returns the Kirchhoff stress of the new state.
//       det f <= 0 is the caller's to refuse beforehand.
//   template <class Real> Real wave_speed_squared(const State<Real>& state) const;   m^2/s^2, an upper bound over directions
//   template <class Real> Real energy_density(const State<Real>& state) const;       J per m^3 of reference volume
//   template <class Real> SymTensor<Real> kirchhoff_stress(const State<Real>& state) const;
//   double density() const;                                                          kg/m^3, reference
//   static constexpr const char* law_name;                                           as written in scenes
//   static constexpr bool flows;                                                     has a yield surface
//
// The law supplies the speed that limits dt, so stress and time step cannot drift apart.

#include "bulkley/base/tensor.hpp"

namespace bulkley {

/// The elastic state of a material point.
template <class Real>
struct State {
  SymTensor<Real> left_cauchy_green;  ///< isochoric, det = 1
  Real volume_ratio;                  ///< J
};

template <class Real>
struct Update {
  SymTensor<Real> kirchhoff_stress;  ///< Pa
  Real plastic_shear_rate;           ///< sqrt(2) gamma, 1/s; 0 where elastic
  Real dissipation;                  ///< J per m^3 of reference volume, in this step; >= 0
};

}  // namespace bulkley
