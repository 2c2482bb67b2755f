#pragma once
// B-spline weights of one axis (docs/theory.md, "Weights"). Index arithmetic of stencils exists only here and in tile.hpp.

#include "bulkley/base/pack.hpp"
#include "grid/grid_geometry.hpp"

namespace bulkley {

/// Weights of the nodes base, base + 1, ... along one axis for a particle at distance `fx` (in cells) above the base node:
/// fx in [1/2, 3/2) for the quadratic spline (T1), [1, 2) for the cubic one (T2).
template <SplineOrder order, class Real>
inline void spline_weights(Real fx, Real (&w)[stencil_width(order)]) {
  if constexpr (order == SplineOrder::quadratic) {
    const Real a = 1.5 - fx, b = fx - 1.0, c = fx - 0.5;
    w[0] = 0.5 * a * a;
    w[1] = 0.75 - b * b;
    w[2] = 0.5 * c * c;
  } else {
    const Real a = 2.0 - fx, b = fx - 1.0;  // distances to nodes 2 and 1, both in [0, 1]
    w[0] = a * a * a * (1.0 / 6.0);
    w[1] = (0.5 * b - 1.0) * b * b + 2.0 / 3.0;
    w[2] = (0.5 * a - 1.0) * a * a + 2.0 / 3.0;
    w[3] = b * b * b * (1.0 / 6.0);
  }
}

/// Derivatives d w / d xi, xi = x / dx, of the weights above.
template <SplineOrder order, class Real>
inline void spline_derivatives(Real fx, Real (&d)[stencil_width(order)]) {
  if constexpr (order == SplineOrder::quadratic) {
    d[0] = fx - 1.5;
    d[1] = -2.0 * (fx - 1.0);
    d[2] = fx - 0.5;
  } else {
    const Real a = 2.0 - fx, b = fx - 1.0;
    d[0] = -0.5 * a * a;
    d[1] = (1.5 * b - 2.0) * b;
    d[2] = -(1.5 * a - 2.0) * a;
    d[3] = 0.5 * b * b;
  }
}

/// The integral of the spline of a node from -infinity to `distance`, in cells from it: 0 to 1.
inline double spline_integral(SplineOrder order, double distance) {
  if (distance > 0.0) return 1.0 - spline_integral(order, -distance);
  const double d = distance;
  if (order == SplineOrder::quadratic) {
    const double a = d + 1.5;
    return a <= 0.0 ? 0.0 : d < -0.5 ? a * a * a / 6.0 : 0.5 + (0.75 - d * d / 3.0) * d;
  }
  const double a = d + 2.0;
  return a <= 0.0 ? 0.0 : d < -1.0 ? a * a * a * a / 24.0 : 0.5 + ((2.0 / 3.0) - (1.0 / 3.0 + 0.125 * d) * d * d) * d;
}

/// D_p^-1 dx^2: the inverse of the second moment of the weights (T3), 4 (quadratic) or 3 (cubic), whatever the position.
constexpr double inverse_second_moment(SplineOrder order) { return order == SplineOrder::quadratic ? 4.0 : 3.0; }

/// Upper bound of the sum of the weights of one node over all particles, divided by the largest number of particles with the
/// same base cell: (sum over base cells of the largest weight in it)^3, rounded up.
constexpr double weight_sum_bound(SplineOrder order) { return order == SplineOrder::quadratic ? 5.36 : 4.64; }

/// The same with each weight times the distance from particle to node, in cells, divided by weight_sum_bound; rounded up.
constexpr double moment_sum_ratio(SplineOrder order) { return order == SplineOrder::quadratic ? 0.65 : 0.725; }

/// The same with each weight replaced by dx times its gradient's norm, divided by weight_sum_bound; rounded up.
constexpr double gradient_sum_ratio(SplineOrder order) { return order == SplineOrder::quadratic ? 2.98 : 2.43; }

}  // namespace bulkley
