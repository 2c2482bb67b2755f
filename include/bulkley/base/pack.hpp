#pragma once
// A pack of doubles processed in one vector instruction, through the compiler's own vector types.
//
// Numerical code is written once, as a template on `Real`, and runs for `double` (one particle) and for
// `Pack` (n_lanes particles). Every lane is computed by the same operations for any values of its neighbours,
// so a particle's result never depends on which particles are in its pack.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace bulkley {

#if defined(__AVX512F__)
inline constexpr int n_lanes = 8;
#else
inline constexpr int n_lanes = 4;
#endif

using Pack [[gnu::vector_size(n_lanes * 8)]] = double;            ///< n_lanes doubles
using PackMask [[gnu::vector_size(n_lanes * 8)]] = std::int64_t;  ///< result of a comparison: 0 or -1 a lane

template <class Real>
struct MaskOf;
template <>
struct MaskOf<double> {
  using type = bool;
};
template <>
struct MaskOf<Pack> {
  using type = PackMask;
};
/// The type of `Real < Real`: bool for double, PackMask for Pack.
template <class Real>
using Mask = typename MaskOf<Real>::type;

/// Integer type with as many lanes as `Real` (int64 or PackMask), for bit manipulation.
template <class Real>
struct BitsOf;
template <>
struct BitsOf<double> {
  using type = std::int64_t;
};
template <>
struct BitsOf<Pack> {
  using type = PackMask;
};
template <class Real>
using Bits = typename BitsOf<Real>::type;

/// All lanes equal to `value`.
template <class Real>
inline Real broadcast(double value) {
  if constexpr (std::is_same_v<Real, double>)
    return value;
  else
    return Real{} + value;
}

inline Pack load(const double* from) {
  Pack result;
  std::memcpy(&result, from, sizeof result);
  return result;
}
inline void store(double* to, Pack value) { std::memcpy(to, &value, sizeof value); }

inline double select(bool mask, double if_true, double if_false) { return mask ? if_true : if_false; }
inline Pack select(PackMask mask, Pack if_true, Pack if_false) { return mask ? if_true : if_false; }

inline bool any(bool mask) { return mask; }
inline bool any(PackMask mask) {
  using Bytes [[gnu::vector_size(n_lanes)]] = std::int8_t;
  const Bytes narrow = __builtin_convertvector(mask, Bytes);
  std::conditional_t<n_lanes == 8, std::uint64_t, std::uint32_t> bits;  // all lanes in one word
  static_assert(sizeof bits == sizeof narrow);
  std::memcpy(&bits, &narrow, sizeof bits);
  return bits != 0;
}

template <class Real>
inline Real minimum(Real a, Real b) {
  return select(a < b, a, b);
}
template <class Real>
inline Real maximum(Real a, Real b) {
  return select(a > b, a, b);
}
template <class Real>
inline Real absolute(Real a) {
  return select(a < broadcast<Real>(0.0), -a, a);
}

/// from[index], for each lane's index.
inline double gather(const double* from, std::int64_t index) { return from[index]; }
inline Pack gather(const double* from, PackMask index) {
  // One initialiser: lanes written one after the other would wait for each other.
  return [&]<std::size_t... lane>(std::index_sequence<lane...>) {
    return Pack{from[index[lane]]...};
  }(std::make_index_sequence<n_lanes>{});
}

inline double square_root(double a) { return std::sqrt(a); }
inline Pack square_root(Pack a) {
  alignas(sizeof(Pack)) double lanes[n_lanes];  // a loop over an array is vectorised, one over lanes is not
  store(lanes, a);
  for (int lane = 0; lane < n_lanes; ++lane) lanes[lane] = std::sqrt(lanes[lane]);
  return load(lanes);
}

inline double round_down(double a) { return std::floor(a); }
inline Pack round_down(Pack a) {
  alignas(sizeof(Pack)) double lanes[n_lanes];
  store(lanes, a);
  for (int lane = 0; lane < n_lanes; ++lane) lanes[lane] = std::floor(lanes[lane]);
  return load(lanes);
}

}  // namespace bulkley
