#pragma once
// Eigenvalues and eigenvectors of symmetric 3x3 tensors, for `double` and `Pack` from one source.

#include "bulkley/base/pack_math.hpp"
#include "bulkley/base/tensor.hpp"

namespace bulkley {

/// b = sum_k value[k] n_k n_k^T with n_k the k-th column of `axes`, orthonormal. The values are in no order.
template <class Real>
struct Spectrum {
  Real value[3];
  Tensor<Real> axes;
};

/// Cyclic Jacobi rotations (Golub & Van Loan 2013, section 8.5): to rounding, also for eigenvalues that are equal or nearly
/// so, and by the same operations in every lane. Requires finite components; others give NaN. Not collective.
template <class Real>
inline Spectrum<Real> spectrum(SymTensor<Real> b) {
  const Real zero = broadcast<Real>(0.0), one = broadcast<Real>(1.0);
  Spectrum<Real> result{{zero, zero, zero}, {{one, zero, zero, zero, one, zero, zero, zero, one}}};
  Tensor<Real>& v = result.axes;
  constexpr int plane[3][3] = {{0, 1, 2}, {1, 2, 0}, {0, 2, 1}};  // p, q, and the axis left alone
  constexpr int sweeps_cap = 8;  // each squares the error or better once it is small; 5 were the most seen
  for (int sweep = 0; sweep < sweeps_cap; ++sweep) {
    const Real off = b.c[3] * b.c[3] + b.c[4] * b.c[4] + b.c[5] * b.c[5];
    const Real diagonal = b.c[0] * b.c[0] + b.c[1] * b.c[1] + b.c[2] * b.c[2];
    // A lane that has converged is left alone, so that its result does not depend on the others. One with NaN never has.
    const Mask<Real> active = select(off <= 1e-34 * diagonal, zero, one) > zero;
    if (!any(active)) break;
    for (const auto& [p, q, r] : plane) {
      Real& b_pq = b.c[symmetric_index(p, q)];
      Real& b_pr = b.c[symmetric_index(p, r)];
      Real& b_qr = b.c[symmetric_index(q, r)];
      const Mask<Real> turns = active & (b_pq * b_pq > 1e-40 * diagonal);
      // tan of the angle that takes b_pq away: the smaller root of t^2 + 2 theta t - 1 = 0, theta = (b_qq - b_pp) / 2 b_pq
      const Real gap = b.c[q] - b.c[p], twice = 2.0 * b_pq;
      const Real root = absolute(gap) + square_root(gap * gap + twice * twice);
      const Real numerator = select(gap < zero, -twice, twice);
      const Real t = select(turns, numerator / select(turns, root, one), zero);
      const Real c = one / square_root(one + t * t);
      const Real s = t * c;
      b.c[p] -= t * b_pq;
      b.c[q] += t * b_pq;
      b_pq = select(turns, zero, b_pq);
      const Real old_pr = b_pr;
      b_pr = c * old_pr - s * b_qr;
      b_qr = s * old_pr + c * b_qr;
      for (int a = 0; a < 3; ++a) {
        const Real old = v(a, p);
        v(a, p) = c * old - s * v(a, q);
        v(a, q) = s * old + c * v(a, q);
      }
    }
  }
  for (int k = 0; k < 3; ++k) result.value[k] = b.c[k];
  return result;
}

/// sum_k value[k] n_k n_k^T. Not collective.
template <class Real>
inline SymTensor<Real> from_spectrum(const Real (&value)[3], const Tensor<Real>& axes) {
  SymTensor<Real> b;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      Real sum = broadcast<Real>(0.0);
      for (int k = 0; k < 3; ++k) sum += value[k] * axes(i, k) * axes(j, k);
      b.c[symmetric_index(i, j)] = sum;
    }
  return b;
}

}  // namespace bulkley
