#pragma once
// Exponential, logarithm and inverse cube root for `double` and `Pack` from one source, without library calls, so that the
// single material point and the vector kernel compute the same. Polynomial coefficients: interpolation at Chebyshev nodes,
// computed with 60 digits; each truncation error is below 1e-17 relative. Not collective.

#include <cstdint>
#include <cstring>
#include <limits>

#include "bulkley/base/pack.hpp"

namespace bulkley {

/// The bit pattern of each lane.
template <class Real>
inline Bits<Real> to_bits(Real a) {
  Bits<Real> bits;
  std::memcpy(&bits, &a, sizeof bits);
  return bits;
}

template <class Real>
inline Real from_bits(Bits<Real> bits) {
  Real a;
  std::memcpy(&a, &bits, sizeof a);
  return a;
}

namespace pack_math {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// ln 2 in two parts; the first has 36 bits after the point, so that its product with a binary exponent is exact.
inline constexpr double ln2_high = 0x1.62e42fefa0000p-1;
inline constexpr double ln2_low = 0x1.cf79abc9e3b3ap-40;

// Adding 1.5 * 2^52 rounds |a| < 2^51 to an integer, which then is in the low bits of the sum.
inline constexpr double to_integer = 0x1.8p52;
inline constexpr std::int64_t to_integer_bits = 0x4338000000000000;

inline constexpr int mantissa_bits = 52;

}  // namespace pack_math

/// e^x within 2 ulp for -708.39 <= x <= 709.78; unspecified beyond.
template <class Real>
inline Real bounded_exponential(Real x) {
  using namespace pack_math;
  // x = k ln 2 + r, |r| <= ln 2 / 2
  const Real shifted = x * 0x1.71547652b82fep+0 + to_integer;
  const Real k = shifted - to_integer;
  const Real r = (x - k * ln2_high) - k * ln2_low;
  // Pairs of terms, then pairs of pairs (Estrin): a third of the latency of Horner's scheme.
  const Real r2 = r * r, r4 = r2 * r2;
  const Real q0 = (0.5 + 0.1666666666666667 * r) + (0.04166666666666667 + 0.008333333333326136 * r) * r2;
  const Real q4 =
      (0.0013888888888883748 + 0.00019841269874820627 * r) + (2.4801587325547743e-05 + 2.7557255400206422e-06 * r) * r2;
  const Real q8 = (2.75572736431103e-07 + 2.5105217004720745e-08 * r) + 2.0914686968086876e-09 * r2;
  const Real q = q0 + (q4 + q8 * r4) * r4;
  const Real e_r = 1.0 + (r + r2 * q);
  return from_bits<Real>(to_bits(e_r) + ((to_bits(shifted) - to_integer_bits) << mantissa_bits));
}

/// e^x within 2 ulp. +infinity above 709.78, exactly 0 below -708.39 (results are never subnormal); NaN for NaN.
template <class Real>
inline Real exponential(Real x) {
  using namespace pack_math;
  constexpr double largest = 709.78, smallest = -708.39;
  const Real bounded = maximum(minimum(x, broadcast<Real>(largest)), broadcast<Real>(smallest));  // also for NaN
  const Real in_range = select(x >= broadcast<Real>(smallest), bounded_exponential(bounded), broadcast<Real>(0.0));
  return select(x <= broadcast<Real>(largest), in_range, x + infinity);
}

/// ln x within 2 ulp for x > 0 that is normal and finite; unspecified else.
template <class Real>
inline Real normal_logarithm(Real x) {
  using namespace pack_math;
  constexpr std::int64_t sqrt_half_bits = 0x3FE6A09E667F3BCD;
  // x = 2^k (1 + f), sqrt(1/2) <= 1 + f < sqrt(2)
  const Bits<Real> bits = to_bits(x);
  const Bits<Real> exponent = (bits - sqrt_half_bits) >> mantissa_bits;
  const Real f = from_bits<Real>(bits - (exponent << mantissa_bits)) - 1.0;
  const Real k = from_bits<Real>(exponent + to_integer_bits) - to_integer;
  // ln(1 + f) = 2 artanh s = f - s (f - z p(z)), s = f / (2 + f), z = s^2
  const Real s = f / (2.0 + f);
  const Real z = s * s, z2 = z * z;
  const Real p0 = (0.666666666666667 + 0.39999999999899444 * z) + (0.2857142862600327 + 0.22222211130259878 * z) * z2;
  const Real p4 = (0.18182889455674947 + 0.15331710618210773 * z) + 0.14616585424888623 * z2;
  const Real p = p0 + p4 * (z2 * z2);
  return k * ln2_high + (f - (s * (f - z * p) - k * ln2_low));
}

/// ln x within 2 ulp, subnormal x included. -infinity for 0, NaN for x < 0 and NaN, +infinity for +infinity.
template <class Real>
inline Real logarithm(Real x) {
  using namespace pack_math;
  constexpr double subnormal_exponent = 54.0, subnormal_scale = 0x1p54, smallest_normal = std::numeric_limits<double>::min();
  const Real zero = broadcast<Real>(0.0);
  const Mask<Real> subnormal = x < broadcast<Real>(smallest_normal);
  // What is not above 0 is replaced as well: its bits would overflow.
  const Real scaled = maximum(x * subnormal_scale, broadcast<Real>(smallest_normal));
  const Real ln_x = normal_logarithm(select(subnormal, scaled, x)) -
                    select(subnormal, broadcast<Real>(subnormal_exponent * (ln2_high + ln2_low)), zero);
  const Real at_most_zero = select(x == zero, broadcast<Real>(-infinity), broadcast<Real>(not_a_number));
  return select(x > zero, select(x < broadcast<Real>(infinity), ln_x, x), at_most_zero);
}

/// x^y = e^(y ln x) for x > 0. The error grows with the size of the result's logarithm: 2 + 2 |y ln x| ulp.
template <class Real>
inline Real power(Real x, Real y) {
  return exponential(y * logarithm(x));
}

/// x^(-1/3) within 2 ulp for normal finite x > 0; any other x gives NaN.
template <class Real>
inline Real inverse_cube_root(Real x) {
  using namespace pack_math;
  // The upper 44 bits of x, read as a fixed-point number, approximate 1023 + log2 x; one third of it, negated and shifted,
  // are the bits of a first guess with |1 - x t^3| < 0.11.
  constexpr int dropped = 20;
  constexpr double two_52 = 0x1p52;
  constexpr std::int64_t two_52_bits = 0x4330000000000000;
  constexpr double offset = 1363.932 * 0x1p32;
  const Real upper = from_bits<Real>((to_bits(x) >> dropped) + two_52_bits) - two_52;
  const Real guess = (offset - upper * (1.0 / 3.0)) + to_integer;
  Real t = from_bits<Real>((to_bits(guess) - to_integer_bits) << dropped);
  // (x t^3)^(-1/3) = (1 - d)^(-1/3) to third order in d: two passes take the error to 1e-5 and to rounding.
  for (int pass = 0; pass < 2; ++pass) {
    const Real d = 1.0 - x * t * (t * t);
    t = t + t * (d * (1.0 / 3.0 + d * (2.0 / 9.0 + d * (14.0 / 81.0))));
  }
  const Mask<Real> large_enough = x >= broadcast<Real>(std::numeric_limits<double>::min()),
                   finite = x < broadcast<Real>(infinity);
  return select(large_enough & finite, t, broadcast<Real>(not_a_number));
}

}  // namespace bulkley
