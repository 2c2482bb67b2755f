#pragma once
// The return of return_map.hpp for particles that stand for a layer across which the stress falls (docs/theory.md, (T13f)).

#include "material/return_map.hpp"

namespace bulkley {

inline constexpr int layer_return_iterations_cap = 64;  ///< at most 6 are needed for 1/3 <= m <= 10 and any B

/// Root zeta > 0 of (T13g): zeta + B (zeta^(m + 1) - max(0, zeta - 1)^(m + 1)) = trial, for lanes in `active` (others are unspecified). In
/// u = ln zeta the left side increases; Halley's method starts from a bound above. Not collective.
template <class Real>
inline OverstressSplit<Real> split_in_layer(Real log_B, Real trial, double m, Mask<Real> active) {
  const Real zero = broadcast<Real>(0.0), one = broadcast<Real>(1.0), smallest = broadcast<Real>(-708.0);
  const double power = m + 1.0;
  // A change d below this ends the search: what is left is of its cube, or of d^(1 + min(m, 1)) where it passes zeta = 1.
  const Real tolerance = broadcast<Real>((m < 1.0 ? 1e-5 : 2e-4) / power);
  const Real log_trial = normal_logarithm(trial), log_ratio = log_trial - log_B;
  Real u = minimum(log_trial, maximum(log_ratio * (1.0 / m), log_ratio * (1.0 / power)));
  OverstressSplit<Real> split{zero, trial};  // where zeta is below all numbers
  active = active & (u > smallest);
  for (int iteration = 0; any(active); ++iteration) {
    if (iteration == layer_return_iterations_cap) {
      split.remaining = select(active, broadcast<Real>(pack_math::not_a_number), split.remaining);
      break;
    }
    // D = B (zeta^power - beyond^power), S = zeta D'(zeta) / power and the second derivative by u, from V = B zeta^m.
    const Real zeta = bounded_exponential(maximum(u, smallest));
    const Real V = bounded_exponential(maximum(log_B + m * u, smallest));
    Real D = V * zeta, S = D, curvature = power * D;
    const Mask<Real> flows_throughout = zeta > broadcast<Real>(1.0 + 1e-6);  // nearer to 1 the second term is nothing, and its slope rounding
    if (any(flows_throughout)) {
      const Mask<Real> far = zeta > broadcast<Real>(1e4);
      const Real beyond = select(flows_throughout, zeta - 1.0, one), inverse = 1.0 / beyond;
      Real difference = D - bounded_exponential(minimum(maximum(log_B + power * normal_logarithm(beyond), smallest), broadcast<Real>(709.0)));
      if (any(far)) {
        const Real part = 1.0 / zeta, q = power * (1.0 + part * (0.5 + (1.0 / 3.0) * part)), small = q * part;
        difference = select(far, V * q * (1.0 - small * (0.5 - (1.0 / 6.0) * small)), difference);
      }
      const Real slope = (difference - V) * (1.0 + inverse);
      D = select(flows_throughout, difference, D);
      S = select(flows_throughout, slope, S);
      curvature = select(flows_throughout, power * slope - m * (V + (V - slope) * inverse), curvature);
    }
    const Real inverse_slope = 1.0 / (zeta + power * S), second = zeta + power * curvature;
    const Real newton = ((zeta - trial) + D) * inverse_slope;
    const Real bend = maximum(minimum(0.5 * newton * second * inverse_slope, broadcast<Real>(0.5)), broadcast<Real>(-0.5));
    const Real change = newton * (1.0 + bend);
    const Real half_square = 0.5 * (change * change);
    split.remaining = select(active, zeta - zeta * (change - half_square), split.remaining);
    split.relaxed = select(active, D - power * (S * change - curvature * half_square), split.relaxed);
    u -= change;
    active = active & (absolute(change) > tolerance);
  }
  return split;
}

/// The flow rule's mean rate where the stress falls linearly from s + a to s - a, with m = 1/h and x = s - radius:
/// gamma = ((x + a)^(m + 1) - max(0, x - a)^(m + 1)) / (2 a (m + 1) eta^m), 0 for x < -a. Backward Euler as in `flow_return`, with
/// a = `fall` times the yield radius, of the lanes where `fall` is more than 0; the others are `plain`. Apart from flow_step, whose products
/// shall not fuse with these. Not collective.
template <class Real, class Number>
[[gnu::noinline]] FlowReturn<Real> layer_return(const FlowReturn<Real>& plain, Real trial_norm, double modulus, Real mean, double dt,
                                                const FlowRule<Number>& rule, Real fall) {
  constexpr double smallest = std::numeric_limits<double>::min(), least_part = 1e-12;
  const Real zero = broadcast<Real>(0.0), one = broadcast<Real>(1.0);
  const Mask<Real> in_layer = fall > zero;
  // So small a part of the stress makes no difference, and keeps the equation within bounds where there is no yield stress.
  const Real reach = maximum(maximum(fall * rule.radius, least_part * trial_norm), broadcast<Real>(smallest));
  const Real lowest = rule.radius - reach;
  const Mask<Real> flows = (zero + rule.eta) < broadcast<Real>(pack_math::infinity);
  const Mask<Real> yields = in_layer & flows & (trial_norm > maximum(lowest, zero));
  FlowReturn<Real> result{plain.yields, select(in_layer, trial_norm, plain.norm), select(in_layer, one, plain.ratio),
                          select(in_layer, zero, plain.rate)};
  result.yields = in_layer ? yields : plain.yields;
  if (!any(yields)) return result;

  const Real width = select(yields, 2.0 * reach, one);
  const Real trial = maximum(select(yields, trial_norm - lowest, one) / width, broadcast<Real>(smallest));
  const double stiffness = 2.0 * dt * modulus;
  OverstressSplit<Real> split{zero, trial};  // eta = 0: all of it relaxes
  const Mask<Real> viscous = yields & (zero + rule.eta > zero);
  if (any(viscous)) {
    const double m = 1.0 / rule.h;
    const Real log_B = (logarithm(stiffness / (m + 1.0)) - m * rule.log_eta) + normal_logarithm(mean) + (m - 1.0) * normal_logarithm(width);
    const OverstressSplit<Real> root = split_in_layer(log_B, trial, m, viscous);
    if constexpr (std::is_same_v<Number, double>)
      split = root;
    else
      split = {select(viscous, root.remaining, zero), select(viscous, root.relaxed, trial)};
  }
  const Real norm = lowest + width * split.remaining;
  result.norm = select(yields, norm, result.norm);
  result.ratio = select(yields, norm / trial_norm, result.ratio);
  result.rate = select(yields, width * split.relaxed / (stiffness * mean), result.rate);
  return result;
}

}  // namespace bulkley
