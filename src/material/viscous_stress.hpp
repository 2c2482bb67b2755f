#pragma once
// Stress that follows the rate of deformation at once.

#include "bulkley/base/pack_math.hpp"
#include "bulkley/material/law.hpp"

namespace bulkley {

/// The deviator of the rate of deformation, dev sym L, 1/s. Not collective.
template <class Real>
inline SymTensor<Real> shear_rate_tensor(const Tensor<Real>& L) {
  return deviator(SymTensor<Real>{L(0, 0), L(1, 1), L(2, 2), 0.5 * (L(0, 1) + L(1, 0)), 0.5 * (L(1, 2) + L(2, 1)),
                                  0.5 * (L(0, 2) + L(2, 0))});
}

/// Adds the Newtonian stress 2 eta J dev D to a Kirchhoff stress, and 2 eta J dev D : dev D dt to the dissipation. Not
/// collective.
template <class Real>
inline void add_viscous_stress(Update<Real>& result, const Tensor<Real>& L, Real J, double viscosity, double dt) {
  const SymTensor<Real> rate = shear_rate_tensor(L);
  const Real factor = J * (2.0 * viscosity);
  for (int c = 0; c < 6; ++c) result.kirchhoff_stress.c[c] += factor * rate.c[c];
  result.dissipation += factor * norm_squared(rate) * dt;
}

}  // namespace bulkley
