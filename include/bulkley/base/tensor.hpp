#pragma once
// 3x3 tensors whose components are `double` or `Pack`; the few operations that the constitutive laws need.

#include "bulkley/base/pack.hpp"

namespace bulkley {

/// A full 3x3 tensor, row-major: component (a, b) at 3 a + b.
template <class Real>
struct Tensor {
  Real c[9];
  Real operator()(int a, int b) const { return c[3 * a + b]; }
  Real& operator()(int a, int b) { return c[3 * a + b]; }
};

/// Index of (a, b) in the symmetric storage order xx yy zz xy yz xz.
constexpr int symmetric_index(int a, int b) {
  constexpr int table[9] = {0, 3, 5, 3, 1, 4, 5, 4, 2};
  return table[3 * a + b];
}

/// A symmetric 3x3 tensor, stored as xx yy zz xy yz xz.
template <class Real>
struct SymTensor {
  Real c[6];
  Real operator()(int a, int b) const { return c[symmetric_index(a, b)]; }
};

template <class Real>
inline Real trace(const SymTensor<Real>& t) {
  return t.c[0] + t.c[1] + t.c[2];
}

template <class Real>
inline Real determinant(const SymTensor<Real>& t) {
  return t.c[0] * (t.c[1] * t.c[2] - t.c[4] * t.c[4]) - t.c[3] * (t.c[3] * t.c[2] - t.c[4] * t.c[5]) +
         t.c[5] * (t.c[3] * t.c[4] - t.c[1] * t.c[5]);
}

template <class Real>
inline Real determinant(const Tensor<Real>& t) {
  return t.c[0] * (t.c[4] * t.c[8] - t.c[5] * t.c[7]) - t.c[1] * (t.c[3] * t.c[8] - t.c[5] * t.c[6]) +
         t.c[2] * (t.c[3] * t.c[7] - t.c[4] * t.c[6]);
}

/// Frobenius norm squared, t : t.
template <class Real>
inline Real norm_squared(const SymTensor<Real>& t) {
  return t.c[0] * t.c[0] + t.c[1] * t.c[1] + t.c[2] * t.c[2] + 2.0 * (t.c[3] * t.c[3] + t.c[4] * t.c[4] + t.c[5] * t.c[5]);
}

/// dev t = t - (tr t / 3) 1.
template <class Real>
inline SymTensor<Real> deviator(const SymTensor<Real>& t) {
  const Real mean = trace(t) * (1.0 / 3.0);
  return {t.c[0] - mean, t.c[1] - mean, t.c[2] - mean, t.c[3], t.c[4], t.c[5]};
}

/// f b f^T for symmetric b.
template <class Real>
inline SymTensor<Real> push_forward(const Tensor<Real>& f, const SymTensor<Real>& b) {
  Tensor<Real> fb;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) fb(i, j) = f(i, 0) * b(0, j) + f(i, 1) * b(1, j) + f(i, 2) * b(2, j);
  SymTensor<Real> result;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      result.c[symmetric_index(i, j)] = fb(i, 0) * f(j, 0) + fb(i, 1) * f(j, 1) + fb(i, 2) * f(j, 2);
  return result;
}

}  // namespace bulkley
