#pragma once
// The return of return_map.hpp for particles that stand for a layer across which the stress falls (docs/theory.md, (T13f)).

#include "material/return_map.hpp"

namespace bulkley {

inline constexpr double layer_is_thin = 1000.0;         ///< overstress over a from which on the flow rule is as good
inline constexpr int layer_return_iterations_cap = 64;  ///< at most 8 are needed for 1/3 <= m <= 10

/// The flow rule's mean rate where the stress falls linearly from s + a to s - a, with m = 1/h and x = s - radius:
/// gamma = ((x + a)^(m + 1) - max(0, x - a)^(m + 1)) / (2 a (m + 1) eta^m), 0 for x < -a. Backward Euler as in `flow_return`, with
/// a = `fall` times the yield radius: of the lanes where that is more than 0, and more than a thousandth of the overstress in `plain`, which is
/// what `flow_return` says; the others are `plain`. In z = (x + a) / (2 a) it reads z + B (z^(m + 1) - max(0, z - 1)^(m + 1)) = z_trial. Its
/// left side increases with ln z, for m >= 1 convexly: Newton's method descends from a bound above. Apart from flow_step, whose products
/// shall not fuse with these. Not collective.
template <class Real, class Number>
[[gnu::noinline]] FlowReturn<Real> layer_return(const FlowReturn<Real>& plain, Real trial_norm, double modulus, Real mean, double dt,
                                                const FlowRule<Number>& rule, Real fall) {
  constexpr double smallest = std::numeric_limits<double>::min();
  const Real zero = broadcast<Real>(0.0), one = broadcast<Real>(1.0);
  const Real radius = zero + rule.radius, reach = fall * radius;
  const Real lowest = radius - reach;
  const bool never = !any((zero + rule.eta) < broadcast<Real>(pack_math::infinity));
  const Mask<Real> yields = (reach > zero) & (trial_norm > lowest) & (plain.norm - radius < layer_is_thin * reach);
  if (never || !any(yields)) return plain;

  const Real width = select(yields, 2.0 * reach, one);
  const Real trial = maximum(select(yields, trial_norm - lowest, one) / width, broadcast<Real>(smallest));
  const double stiffness = 2.0 * dt * modulus;
  OverstressSplit<Real> split{zero, trial};  // eta = 0: all of it relaxes
  const Mask<Real> viscous = yields & (zero + rule.eta > zero);
  if (any(viscous)) {
    const double m = 1.0 / rule.h, power = m + 1.0;
    const Real log_B = (logarithm(stiffness / power) - m * rule.log_eta) + normal_logarithm(mean) + (m - 1.0) * normal_logarithm(width);
    const Real log_trial = normal_logarithm(trial);
    const Real tolerance = broadcast<Real>(1e-7 / power);
    Real u = minimum(log_trial, maximum((log_trial - log_B) * rule.h, (log_trial - log_B) / power));
    Mask<Real> active = viscous;
    for (int iteration = 0; any(active); ++iteration) {
      if (iteration == layer_return_iterations_cap) {
        split.remaining = select(active, broadcast<Real>(pack_math::not_a_number), split.remaining);
        break;
      }
      const Real z = exponential(u), beyond = maximum(z - 1.0, broadcast<Real>(smallest));
      const Real whole = exponential(log_B + power * u);
      const Real above = select(z > one, exponential(log_B + power * normal_logarithm(beyond)), zero);
      const Real relaxed = whole - above, slope = power * (whole - above * (z / beyond));
      const Real change = ((z - trial) + relaxed) / (z + slope);
      split.remaining = select(active, z - z * change, split.remaining);
      split.relaxed = select(active, relaxed - slope * change, split.relaxed);
      u -= change;
      active = active & (absolute(change) > tolerance);
    }
    if constexpr (!std::is_same_v<Number, double>)
      split = {select(viscous, split.remaining, zero), select(viscous, split.relaxed, trial)};
  }
  const Real norm = lowest + width * split.remaining;
  FlowReturn<Real> result = plain;
  result.yields |= yields;
  result.norm = select(yields, norm, plain.norm);
  result.ratio = select(yields, norm / trial_norm, plain.ratio);
  result.rate = select(yields, width * split.relaxed / (stiffness * mean), plain.rate);
  return result;
}

}  // namespace bulkley
