#pragma once
// Two packs side by side: twice the lanes, as two independent chains of instructions, so that one computes while the other
// waits for its operands. A law runs on it through the same source as on `Pack`.

#include "bulkley/base/pack.hpp"

namespace bulkley {

/// T: Pack, or PackMask for masks and bit patterns.
template <class T>
struct Pair {
  T first, second;
};

using PackPair = Pair<Pack>;

template <>
struct MaskOf<PackPair> {
  using type = Pair<PackMask>;
};
template <>
struct BitsOf<PackPair> {
  using type = Pair<PackMask>;
};

namespace pack_pair {

template <class T>
inline T first(const Pair<T>& a) {
  return a.first;
}
template <class T>
inline T second(const Pair<T>& a) {
  return a.second;
}
/// A number stands for all lanes of both.
template <class T>
requires std::is_arithmetic_v<T>
inline T first(T a) { return a; }
template <class T>
requires std::is_arithmetic_v<T>
inline T second(T a) { return a; }

template <class T>
inline constexpr bool is_pair = false;
template <class T>
inline constexpr bool is_pair<Pair<T>> = true;

template <class A, class B>
concept Operands = is_pair<A> || is_pair<B>;

/// function(first halves), function(second halves).
template <class Function, class... A>
inline auto apply(Function function, const A&... a) {
  return Pair<decltype(function(first(a)...))>{function(first(a)...), function(second(a)...)};
}

}  // namespace pack_pair

#define BULKLEY_PAIR_OPERATOR(op)                                         \
  template <class A, class B>                                             \
  requires pack_pair::Operands<A, B>                                      \
  inline auto operator op(const A& a, const B& b) {                       \
    return pack_pair::apply([](auto x, auto y) { return x op y; }, a, b); \
  }
BULKLEY_PAIR_OPERATOR(+)
BULKLEY_PAIR_OPERATOR(-)
BULKLEY_PAIR_OPERATOR(*)
BULKLEY_PAIR_OPERATOR(/)
BULKLEY_PAIR_OPERATOR(<)
BULKLEY_PAIR_OPERATOR(>)
BULKLEY_PAIR_OPERATOR(<=)
BULKLEY_PAIR_OPERATOR(>=)
BULKLEY_PAIR_OPERATOR(==)
BULKLEY_PAIR_OPERATOR(&)
BULKLEY_PAIR_OPERATOR(<<)
BULKLEY_PAIR_OPERATOR(>>)
#undef BULKLEY_PAIR_OPERATOR
template <class T>
inline Pair<T> operator-(const Pair<T>& a) {
  return {-a.first, -a.second};
}
template <class T, class B>
inline Pair<T>& operator+=(Pair<T>& a, const B& b) {
  return a = a + b;
}
template <class T, class B>
inline Pair<T>& operator-=(Pair<T>& a, const B& b) {
  return a = a - b;
}
template <class T, class B>
inline Pair<T>& operator*=(Pair<T>& a, const B& b) {
  return a = a * b;
}

inline PackPair select(const Pair<PackMask>& mask, const PackPair& if_true, const PackPair& if_false) {
  return {select(mask.first, if_true.first, if_false.first), select(mask.second, if_true.second, if_false.second)};
}
inline bool any(const Pair<PackMask>& mask) { return any(mask.first | mask.second); }
inline PackPair square_root(const PackPair& a) { return {square_root(a.first), square_root(a.second)}; }
inline PackPair gather(const double* from, const Pair<PackMask>& index) {
  return {gather(from, index.first), gather(from, index.second)};
}

}  // namespace bulkley
