#pragma once
// The yield stress that a magnetic field gives to a fluid: particles of iron that stand in chains.

#include "bulkley/base/pack_math.hpp"

namespace bulkley {

/// Shear yield stress beyond that without a field: `tanh`: saturation tanh(H/field) (Carlson); `power`: saturation
/// min(1, (H/field)^(3/2)) (Ginder, Davis and Elie). Isotropic: it does not know the direction of the field.
struct FieldYield {
  enum class Form { none, tanh, power };
  Form form = Form::none;
  double saturation = 0.0;  ///< Pa, as a shear rheometer reports it, >= 0
  double field = 1.0;       ///< A/m, > 0

  bool operator==(const FieldYield&) const = default;
  bool given() const { return form != Form::none; }

  /// tau_y(H) - tau_y(0) at the field strength `H` >= 0 (A/m), Pa. Not collective.
  template <class Real>
  Real at(Real H) const {
    const Real x = H * (1.0 / field);
    const Real one = broadcast<Real>(1.0);
    if (form == Form::power) return saturation * minimum(one, x * square_root(x));
    constexpr double saturated = 20.0;  // tanh is 1 to rounding
    if (form == Form::tanh)
      return saturation * (one - 2.0 / (one + exponential(2.0 * minimum(x, broadcast<Real>(saturated)))));
    return broadcast<Real>(0.0);
  }
};

}  // namespace bulkley
