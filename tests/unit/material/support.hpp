#pragma once
// Helpers of the material tests.

#include <cmath>
#include <random>

#include "bulkley/material/material.hpp"

namespace bulkley::material_test {

inline State<double> at_rest() { return {isochoric_identity<double>(), 1.0}; }

/// [0 rate 0; 0 0 0; 0 0 0]
inline Tensor<double> simple_shear(double rate) { return {{0, rate, 0, 0, 0, 0, 0, 0, 0}}; }

template <class Random>
Tensor<double> random_tensor(Random& random, double size) {
  std::normal_distribution<double> normal(0.0, size);
  Tensor<double> t;
  for (double& c : t.c) c = normal(random);
  return t;
}

/// A strained state with det b = 1: f f^T scaled, and a J near 1.
template <class Random>
State<double> random_state(Random& random, double strain) {
  State<double> state = at_rest();
  Tensor<double> gradient = random_tensor(random, strain);
  while (true) {
    Tensor<double> f = gradient;
    for (int a = 0; a < 3; ++a) f(a, a) += 1.0;
    if (determinant(f) > 0.2) break;
    gradient = random_tensor(random, strain);
  }
  deform(state, gradient, 1.0);
  state.volume_ratio = std::uniform_real_distribution<double>(0.7, 1.4)(random);
  return state;
}

inline double norm(const SymTensor<double>& t) { return std::sqrt(norm_squared(t)); }

inline double largest_component(const SymTensor<double>& t) {
  double largest = 0.0;
  for (const double c : t.c) largest = std::max(largest, std::fabs(c));
  return largest;
}

inline double largest_difference(const SymTensor<double>& a, const SymTensor<double>& b) {
  double largest = 0.0;
  for (int c = 0; c < 6; ++c) largest = std::max(largest, std::fabs(a.c[c] - b.c[c]));
  return largest;
}

/// a : L for symmetric a.
inline double contract(const SymTensor<double>& a, const Tensor<double>& L) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum += a(i, j) * L(i, j);
  return sum;
}

/// The foam of the reference tables.
inline HerschelBulkley foam() { return {{200.0, 109000.0, 290.0, 31.9, 27.2, 0.22}}; }

}  // namespace bulkley::material_test
