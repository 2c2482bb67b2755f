#include "integrator/merged_body.hpp"

namespace bulkley {

namespace {

/// The solution of a symmetric positive definite system, of which the lower triangle is read: L D L^T without pivots, the same
/// operations on every rank.
Vec6 solved(Mat6 a, Vec6 b) {
  for (int j = 0; j < 6; ++j)
    for (int i = j + 1; i < 6; ++i) {
      const double factor = a(i, j) / a(j, j);
      for (int k = j + 1; k <= i; ++k) a(i, k) -= factor * a(k, j);
    }
  for (int j = 0; j < 6; ++j)
    for (int i = j + 1; i < 6; ++i) b[i] -= a(i, j) / a(j, j) * b[j];
  for (int j = 5; j >= 0; --j) {
    for (int i = j + 1; i < 6; ++i) b[j] -= a(i, j) * b[i];
    b[j] /= a(j, j);
  }
  return b;
}

}  // namespace

double MergedBody::rate() const {
  return (freedom->dot(own + given + pull) - winding * wound) / (freedom->dot(all * *freedom) + dt * winding);
}

Vec6 MergedBody::velocity() const { return freedom ? Vec6(rate() * *freedom) : solved(all, own + given + pull); }

Vec6 MergedBody::response(const Vec6& impulse) const {
  if (!freedom) return solved(all, impulse);
  return freedom->dot(impulse) / (freedom->dot(all * *freedom) + dt * winding) * *freedom;
}

}  // namespace bulkley
