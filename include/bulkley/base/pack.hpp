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

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

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

using Quad [[gnu::vector_size(32)]] = double;  ///< four numbers of one particle or one node

/// row[r][lane] = number r of quad_at(lane). A pack is put together in registers: one that is loaded after its parts were stored
/// waits until they have left for the cache.
template <class QuadAt>
inline void transpose_quads(const QuadAt& quad_at, Pack (&row)[4]) {
#if defined(__AVX512F__)
  const auto both = [&](int lane) {
    return __builtin_shufflevector(quad_at(lane), quad_at(lane + 4), 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const Pack p0 = both(0), p1 = both(1), p2 = both(2), p3 = both(3);
  const Pack even01 = __builtin_shufflevector(p0, p1, 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack even23 = __builtin_shufflevector(p2, p3, 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack odd01 = __builtin_shufflevector(p0, p1, 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack odd23 = __builtin_shufflevector(p2, p3, 1, 9, 3, 11, 5, 13, 7, 15);
  row[0] = __builtin_shufflevector(even01, even23, 0, 1, 8, 9, 4, 5, 12, 13);
  row[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 8, 9, 4, 5, 12, 13);
  row[2] = __builtin_shufflevector(even01, even23, 2, 3, 10, 11, 6, 7, 14, 15);
  row[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 10, 11, 6, 7, 14, 15);
#else
  const Quad p0 = quad_at(0), p1 = quad_at(1), p2 = quad_at(2), p3 = quad_at(3);
  const Quad even01 = __builtin_shufflevector(p0, p1, 0, 4, 2, 6), odd01 = __builtin_shufflevector(p0, p1, 1, 5, 3, 7);
  const Quad even23 = __builtin_shufflevector(p2, p3, 0, 4, 2, 6), odd23 = __builtin_shufflevector(p2, p3, 1, 5, 3, 7);
  row[0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
  row[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
  row[2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
  row[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
#endif
}

/// The way back: calls put(lane, {row[0][lane], ..., row[3][lane]}) for all lanes.
template <class Put>
inline void transpose_rows(const Pack (&row)[4], const Put& put) {
#if defined(__AVX512F__)
  const Pack xy02 = __builtin_shufflevector(row[0], row[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack zm02 = __builtin_shufflevector(row[2], row[3], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack xy13 = __builtin_shufflevector(row[0], row[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack zm13 = __builtin_shufflevector(row[2], row[3], 1, 9, 3, 11, 5, 13, 7, 15);
  const auto put_both = [&](int lane, Pack both) {
    put(lane, __builtin_shufflevector(both, both, 0, 1, 2, 3));
    put(lane + 4, __builtin_shufflevector(both, both, 4, 5, 6, 7));
  };
  put_both(0, __builtin_shufflevector(xy02, zm02, 0, 1, 8, 9, 4, 5, 12, 13));
  put_both(1, __builtin_shufflevector(xy13, zm13, 0, 1, 8, 9, 4, 5, 12, 13));
  put_both(2, __builtin_shufflevector(xy02, zm02, 2, 3, 10, 11, 6, 7, 14, 15));
  put_both(3, __builtin_shufflevector(xy13, zm13, 2, 3, 10, 11, 6, 7, 14, 15));
#else
  const Quad xy02 = __builtin_shufflevector(row[0], row[1], 0, 4, 2, 6), xy13 = __builtin_shufflevector(row[0], row[1], 1, 5, 3, 7);
  const Quad zm02 = __builtin_shufflevector(row[2], row[3], 0, 4, 2, 6), zm13 = __builtin_shufflevector(row[2], row[3], 1, 5, 3, 7);
  put(0, __builtin_shufflevector(xy02, zm02, 0, 1, 4, 5));
  put(1, __builtin_shufflevector(xy13, zm13, 0, 1, 4, 5));
  put(2, __builtin_shufflevector(xy02, zm02, 2, 3, 6, 7));
  put(3, __builtin_shufflevector(xy13, zm13, 2, 3, 6, 7));
#endif
}

/// row[r] = from[index + r], for each lane's index.
inline void gather_rows(const double* from, std::int64_t index, double (&row)[4]) { std::memcpy(row, from + index, sizeof row); }
inline void gather_rows(const double* from, PackMask index, Pack (&row)[4]) {
  std::int64_t first[n_lanes];
  std::memcpy(first, &index, sizeof first);
  const auto quad_at = [&](int lane) {
    Quad quad;
    std::memcpy(&quad, from + first[lane], sizeof quad);
    return quad;
  };
  transpose_quads(quad_at, row);
}

inline double square_root(double a) { return std::sqrt(a); }
inline double round_down(double a) { return std::floor(a); }
#if defined(__AVX512F__)
// The vector code that GCC makes of the loops below has half the lanes, and stores what is then loaded whole. The forms with a mask,
// which is all lanes, for others start from a number without a value, of which GCC 12 warns.
inline Pack square_root(Pack a) { return _mm512_maskz_sqrt_pd(0xFF, a); }
inline Pack round_down(Pack a) { return _mm512_maskz_roundscale_pd(0xFF, a, _MM_FROUND_TO_NEG_INF); }
#else
inline Pack square_root(Pack a) {
  alignas(sizeof(Pack)) double lanes[n_lanes];  // a loop over an array is vectorised, one over lanes is not
  store(lanes, a);
  for (int lane = 0; lane < n_lanes; ++lane) lanes[lane] = std::sqrt(lanes[lane]);
  return load(lanes);
}
inline Pack round_down(Pack a) {
  alignas(sizeof(Pack)) double lanes[n_lanes];
  store(lanes, a);
  for (int lane = 0; lane < n_lanes; ++lane) lanes[lane] = std::floor(lanes[lane]);
  return load(lanes);
}
#endif

}  // namespace bulkley
