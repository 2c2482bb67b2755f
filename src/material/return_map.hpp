#pragma once
// The scalar equations inside a viscoplastic step: how far the stress relaxes, and which spherical part keeps det b = 1.
// Both are solved by iteration lane by lane, from a first guess that makes the first step the last in nearly all lanes. A
// lane that has converged is frozen, so its result does not depend on the others. A lane that has not converged at the cap
// becomes NaN, which the caller's check for finite results reports.

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "bulkley/base/pack_math.hpp"
#include "bulkley/base/tensor.hpp"
#include "material/overstress_table.hpp"

namespace bulkley {

/// gamma = (max(0, s - radius) / eta)^(1/h), with s = ||dev sigma|| and gamma the norm of the plastic rate of deformation.
/// Number: double, or Real where radius and eta differ from particle to particle.
template <class Number>
struct FlowRule {
  Number radius;                           ///< sqrt(2/3) sigma_Y, Pa
  Number eta;                              ///< Pa s^h; infinite (one for all particles only): elastic
  double h;                                ///< 1
  const OverstressTable* table = nullptr;  ///< of this h; without it the same root takes more steps
  Number log_eta = logarithm(eta);
};

/// The two parts of a trial overstress: remaining + relaxed = 1.
template <class Real>
struct OverstressSplit {
  Real remaining;  ///< xi
  Real relaxed;    ///< A xi^m = 1 - xi, without cancellation where it is small
};

inline constexpr int overstress_iterations_cap = 64;  ///< at most 6 are needed for 1/3 <= m <= 10 and any A

/// Root xi in (0, 1] of (T21): xi + A xi^m = 1, for lanes in `active` (others are unspecified). In u = ln xi the residual
/// e^u + e^(log_A + m u) - 1 is convex and increases, for every m > 0: Newton's method descends to the root, after one step up at
/// most. `table`, if given, is that of h = 1/m, and gives the first guess. Not collective.
template <class Real>
inline OverstressSplit<Real> split_overstress(Real log_A, double m, Mask<Real> active, const OverstressTable* table) {
  // A change d below this ends the search: its cube is below rounding, in e^(-d) and in e^(-m d).
  const Real tolerance = broadcast<Real>(1e-5 / std::max(1.0, m));
  constexpr double smallest = -708.0;  // e^smallest is nothing next to 1
  Real u = table ? table->log_remaining(log_A) : minimum(broadcast<Real>(0.0), log_A * (-1.0 / m));
  OverstressSplit<Real> split{broadcast<Real>(1.0), broadcast<Real>(0.0)};
  for (int iteration = 0; any(active); ++iteration) {
    if (iteration == overstress_iterations_cap) {
      split.remaining = select(active, broadcast<Real>(pack_math::not_a_number), split.remaining);
      break;
    }
    const Real xi = bounded_exponential(maximum(u, broadcast<Real>(smallest)));
    const Real a_xi_m = bounded_exponential(maximum(log_A + m * u, broadcast<Real>(smallest)));
    const Real inverse_slope = 1.0 / (xi + m * a_xi_m);
    const Real change = ((xi - 1.0) + a_xi_m) * inverse_slope;
    // The result takes the second order of the change along (Chebyshev's method).
    const Real half_square = 0.5 * (change * change);
    const Real full = change + half_square * ((xi + (m * m) * a_xi_m) * inverse_slope);
    split.remaining = select(active, xi - xi * (full - half_square), split.remaining);
    split.relaxed = select(active, a_xi_m - a_xi_m * (m * full - (m * m) * half_square), split.relaxed);
    u -= change;
    active = active & (absolute(change) > tolerance);
  }
  return split;
}

template <class Real>
struct FlowReturn {
  Mask<Real> yields;  ///< trial stress beyond the yield radius
  Real norm;          ///< ||dev sigma|| at the end of the step, Pa
  Real ratio;         ///< the same over its trial value
  Real rate;          ///< gamma, 1/s
};

/// Backward Euler for ||dev sigma|| (T20): s - s_trial + 2 mu_hat dt ((s - radius)/eta)^(1/h) = 0 (Yue et al. 2015, section
/// 5), in the form xi + A xi^(1/h) = 1, s = radius + y xi, y = s_trial - radius, A = (2 mu_hat dt / y) (y / eta)^(1/h).
/// `trial_norm` s_trial, Pa; mu_hat = `modulus` `mean`, Pa, with mean = tr b_trial / (3 J); dt > 0. Not collective.
template <class Real, class Number>
inline FlowReturn<Real> flow_return(Real trial_norm, double modulus, Real mean, double dt, const FlowRule<Number>& rule) {
  constexpr double smallest = std::numeric_limits<double>::min();
  const Real zero = broadcast<Real>(0.0), one = broadcast<Real>(1.0);
  const Mask<Real> yields = trial_norm > (zero + rule.radius);
  const bool never = !any((zero + rule.eta) < broadcast<Real>(pack_math::infinity));
  if (!any(yields) || never) return {zero > zero, trial_norm, one, zero};  // no lane yields

  const Real overstress = select(yields, trial_norm - rule.radius, one);
  const double stiffness = 2.0 * dt * modulus;
  OverstressSplit<Real> split{zero, one};  // eta = 0: all of it relaxes
  const Mask<Real> viscous = yields & (zero + rule.eta > zero);
  if (any(viscous)) {
    const double m = 1.0 / rule.h;
    const Number log_eta = rule.log_eta;
    const Real log_A = (logarithm(stiffness) - m * log_eta) + normal_logarithm(mean) +
                       (m - 1.0) * normal_logarithm(maximum(overstress, broadcast<Real>(smallest)));
    const OverstressSplit<Real> root = split_overstress(log_A, m, viscous, rule.table);
    if constexpr (std::is_same_v<Number, double>)
      split = root;
    else
      split = {select(viscous, root.remaining, zero), select(viscous, root.relaxed, one)};
  }
  // One division for both: norm / trial_norm and overstress relaxed / (stiffness mean).
  const Real hardness = stiffness * mean;
  const Real inverse = 1.0 / maximum(trial_norm * hardness, broadcast<Real>(smallest));
  const Real norm = rule.radius + overstress * split.remaining;
  return {yields, select(yields, norm, trial_norm), select(yields, norm * hardness * inverse, one),
          select(yields, overstress * split.relaxed * trial_norm * inverse, zero)};
}

inline constexpr int isochoric_iterations_cap = 64;  ///< far above the root each takes half off x: 2^64 = 2e19

/// The x for which det(e + x 1) = 1 (T22): largest root of x^3 - J2 x + J3 - 1 = 0, J2 = e:e/2, J3 = det e, for a traceless
/// e. `upper` must not be below the root. Halley's method, which on this cubic runs monotonically to the root from either
/// side, starts from the root's series in J2 and J3, or from `upper` where e is large. For lanes in `active` (others are
/// unspecified). Not collective.
template <class Real>
inline Real isochoric_mean(Real J2, Real J3, Real upper, Mask<Real> active) {
  // A change below this ends the search: its cube is below rounding.
  constexpr double tolerance = 1e-6;
  const Real series = 1.0 + (1.0 / 3.0) * (J2 - J3) * (1.0 + (1.0 / 3.0) * J3) - (1.0 / 81.0) * (J2 * (J2 * J2));
  Real x = select(J2 < broadcast<Real>(0.5), series, upper);
  for (int iteration = 0; any(active); ++iteration) {
    if (iteration == isochoric_iterations_cap) {
      x = select(active, broadcast<Real>(pack_math::not_a_number), x);
      break;
    }
    const Real residual = x * (x * x - J2) + (J3 - 1.0);
    const Real slope = 3.0 * (x * x) - J2;
    const Real change = residual * slope / (slope * slope - 3.0 * (x * residual));
    x = select(active, x - change, x);
    active = active & (absolute(change) > tolerance * x);
  }
  return select(x > upper, upper, x);  // above by rounding only
}

}  // namespace bulkley
