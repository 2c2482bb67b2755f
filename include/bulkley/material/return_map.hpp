#pragma once
// The scalar equations inside a viscoplastic step: how far the stress relaxes, and which spherical part keeps det b = 1.
// Both are solved by Newton's method lane by lane, descending to the root until the change is small, or is not a descent and
// therefore rounding. A lane that has converged is frozen, so its result does not depend on the others. A lane that has not
// converged at the cap becomes NaN, which the caller's check for finite results reports.

#include <algorithm>
#include <cmath>

#include "bulkley/base/pack_math.hpp"
#include "bulkley/base/tensor.hpp"

namespace bulkley {

/// gamma = (max(0, s - radius) / eta)^(1/h), with s = ||dev tau|| and gamma the norm of the plastic rate of deformation.
struct FlowRule {
  double radius;  ///< sqrt(2/3) sigma_Y, Pa
  double eta;     ///< Pa s^h
  double h;       ///< 1
};

/// The two parts of a trial overstress: remaining + relaxed = 1.
template <class Real>
struct OverstressSplit {
  Real remaining;  ///< xi
  Real relaxed;    ///< A xi^m = 1 - xi, without cancellation where it is small
};

inline constexpr int overstress_iterations_cap = 12;  ///< at most 6 are needed for 1/3 <= m <= 10 and any A

/// Root xi in (0, 1] of (T21): xi + A xi^m = 1, given ln A, for lanes in `active` (others are unspecified).
/// In u = ln xi the residual e^u + e^(ln A + m u) - 1 is convex and increases, for every m > 0, and is >= 0 at
/// u_0 = min(0, -ln A / m): Newton's method descends to the root. Not collective.
template <class Real>
inline OverstressSplit<Real> split_overstress(Real log_A, double m, Mask<Real> active) {
  // A change d below this ends the search: its square is below rounding, in u and in e^(-d) = 1 - d and e^(-m d) = 1 - m d.
  const Real tolerance = broadcast<Real>(1e-8 / std::max(1.0, m));
  Real u = minimum(broadcast<Real>(0.0), log_A * (-1.0 / m));
  OverstressSplit<Real> split{broadcast<Real>(1.0), broadcast<Real>(0.0)};
  for (int iteration = 0; any(active); ++iteration) {
    if (iteration == overstress_iterations_cap) {
      split.remaining = select(active, broadcast<Real>(pack_math::not_a_number), split.remaining);
      break;
    }
    const Real xi = exponential(u);
    const Real a_xi_m = exponential(log_A + m * u);
    const Real change = ((xi - 1.0) + a_xi_m) / (xi + m * a_xi_m);
    split.remaining = select(active, xi - xi * change, split.remaining);
    split.relaxed = select(active, a_xi_m - a_xi_m * (m * change), split.relaxed);
    u -= change;
    active = active & (change > tolerance);
  }
  return split;
}

template <class Real>
struct FlowReturn {
  Mask<Real> yields;  ///< trial stress beyond the yield radius
  Real norm;          ///< ||dev tau|| at the end of the step, Pa
  Real rate;          ///< gamma, 1/s
};

/// Backward Euler for ||dev tau|| (T20): s - s_trial + 2 mu_hat dt ((s - radius)/eta)^(1/h) = 0 (Yue et al. 2015, section
/// 5), in the form xi + A xi^(1/h) = 1, s = radius + y xi, y = s_trial - radius, A = (2 mu_hat dt / y) (y / eta)^(1/h).
/// `trial_norm` s_trial, Pa; `modulus` mu_hat = mu tr b_trial / 3, Pa; dt > 0. Not collective.
template <class Real>
inline FlowReturn<Real> flow_return(Real trial_norm, Real modulus, double dt, const FlowRule& rule) {
  const Real zero = broadcast<Real>(0.0);
  const Mask<Real> yields = trial_norm > broadcast<Real>(rule.radius);
  if (!any(yields) || std::isinf(rule.eta)) return {yields & (zero > zero), trial_norm, zero};

  const Real overstress = select(yields, trial_norm - rule.radius, broadcast<Real>(1.0));
  const Real stiffness = (2.0 * dt) * modulus;
  OverstressSplit<Real> split{zero, broadcast<Real>(1.0)};  // eta = 0: all of it relaxes
  if (rule.eta > 0.0) {
    const double m = 1.0 / rule.h;
    const Real log_A = logarithm(stiffness) + (m - 1.0) * logarithm(overstress) - m * std::log(rule.eta);
    split = split_overstress(log_A, m, yields);
  }
  return {yields, select(yields, rule.radius + overstress * split.remaining, trial_norm),
          select(yields, overstress * split.relaxed / stiffness, zero)};
}

inline constexpr int isochoric_iterations_cap = 64;  ///< far above the root each takes a third off x: 1.5^64 = 2e11

/// The x for which det(e + x 1) = 1 (T22): largest root of x^3 - J2 x + J3 - 1 = 0, J2 = e:e/2, J3 = det e, for a traceless
/// e. `upper` must not be below the root; from there Newton's method descends to it. For lanes in `active` (others are
/// unspecified). Not collective.
template <class Real>
inline Real isochoric_mean(const SymTensor<Real>& e, Real upper, Mask<Real> active) {
  const Real J2 = 0.5 * norm_squared(e);
  const Real J3 = determinant(e);
  Real x = upper;
  for (int iteration = 0; any(active); ++iteration) {
    if (iteration == isochoric_iterations_cap) {
      x = select(active, broadcast<Real>(pack_math::not_a_number), x);
      break;
    }
    const Real change = (x * (x * x - J2) + (J3 - 1.0)) / (3.0 * (x * x) - J2);
    x = select(active, x - change, x);
    active = active & (change > 1e-9 * x);  // the next change would be of the order of this one's square
  }
  return select(x > upper, upper, x);  // above by rounding only
}

}  // namespace bulkley
