#pragma once
// Sums whose bits do not depend on the order of addition (docs/theory.md, "Order-free sums"; after Demmel & Nguyen 2013,
// pre-rounded reproducible summation).
//
// Every addend is rounded to a multiple of one power of two u, chosen so that all partial sums are exact in double.

#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley {

/// The quantum u (T28) for sums whose addends' absolute values sum to at most `bound`, each at most a quarter of it: the
/// smallest power of two with bound < 2^53 u. Precondition: bound finite and >= 0.
inline double rounding_quantum(double bound) {
  BULKLEY_ASSERT(bound >= 0.0 && std::isfinite(bound));
  int exponent = 0;
  std::frexp(bound, &exponent);  // bound < 2^exponent
  return std::ldexp(1.0, exponent - 53);
}

/// M = 1.5 * 2^52 * u (T28) of the same sums: (a + M) - M is `a` rounded to a multiple of u, and any sum of such values is
/// exact. |a| <= bound / 4 < 2^51 u keeps a + M between 2^52 u and 2^53 u, where doubles are spaced by u.
inline double rounding_constant(double bound) { return 0x1.8p52 * rounding_quantum(bound); }

/// `value` rounded to a multiple of the quantum that belongs to `constant`.
template <class Real>
inline Real rounded(Real value, Real constant) {
  return (value + constant) - constant;
}

/// Adds `value` to `sums` in slices: to the first rounded by the first constant, to each of the others what is left, rounded
/// by the next. What is left after the last is dropped.
template <int n, class Real>
inline void add_slices(Real value, const Real (&constants)[n], Real (&sums)[n]) {
  for (int k = 0; k < n; ++k) {
    const Real slice = rounded(value, constants[k]);
    sums[k] += slice;
    value -= slice;
  }
}

}  // namespace bulkley
