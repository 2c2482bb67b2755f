#pragma once
// Helpers of the material tests.

#include <algorithm>
#include <cmath>
#include <random>

#include "material/material.hpp"

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

/// A state in which every lane holds the same.
template <class Real, int n>
State<Real, n> in_every_lane(const State<double, n>& from) {
  State<Real, n> state;
  for (int c = 0; c < 6; ++c) state.left_cauchy_green.c[c] = broadcast<Real>(from.left_cauchy_green.c[c]);
  state.volume_ratio = broadcast<Real>(from.volume_ratio);
  if constexpr (n > 0)
    for (int k = 0; k < n; ++k) state.internal[k] = broadcast<Real>(from.internal[k]);
  return state;
}

template <class Real>
Tensor<Real> in_every_lane(const Tensor<double>& from) {
  Tensor<Real> t;
  for (int c = 0; c < 9; ++c) t.c[c] = broadcast<Real>(from.c[c]);
  return t;
}

inline double of_lane(double value, int) { return value; }
inline double of_lane(const Pack& value, int lane) { return value[lane]; }

/// The state of one lane.
template <class Real, int n>
State<double, n> of_lane(const State<Real, n>& from, int lane) {
  State<double, n> state;
  for (int c = 0; c < 6; ++c) state.left_cauchy_green.c[c] = of_lane(from.left_cauchy_green.c[c], lane);
  state.volume_ratio = of_lane(from.volume_ratio, lane);
  if constexpr (n > 0)
    for (int k = 0; k < n; ++k) state.internal[k] = of_lane(from.internal[k], lane);
  return state;
}

template <class Real>
Update<double> of_lane(const Update<Real>& from, int lane) {
  Update<double> update;
  for (int c = 0; c < 6; ++c) update.kirchhoff_stress.c[c] = of_lane(from.kirchhoff_stress.c[c], lane);
  update.plastic_shear_rate = of_lane(from.plastic_shear_rate, lane);
  update.dissipation = of_lane(from.dissipation, lane);
  return update;
}

/// One update in `Real` arithmetic, the same in every lane; the last lane's outcome.
template <class Real, class Law, int n>
Update<double> advance(const Law& law, State<double, n>& state, const Tensor<double>& L, double dt) {
  State<Real, n> lanes = in_every_lane<Real>(state);
  const Update<Real> update = law.update(lanes, in_every_lane<Real>(L), dt);
  state = of_lane(lanes, n_lanes - 1);
  return of_lane(update, n_lanes - 1);
}

/// A diagonal tensor.
inline Tensor<double> diagonal(double x, double y, double z) { return {{x, 0, 0, 0, y, 0, 0, 0, z}}; }

/// The state of rest of a law, but with the principal stretches of F given.
template <class Law>
State<double, n_internal<Law>> stretched(const Law& law, double x, double y, double z) {
  State<double, n_internal<Law>> state = state_at_rest(law);
  const double J = x * y * z, scale = std::pow(J, -2.0 / 3.0);
  state.left_cauchy_green = {{scale * x * x, scale * y * y, scale * z * z, 0, 0, 0}};
  state.volume_ratio = J;
  return state;
}

/// Hooke's law: kappa tr e 1 + 2 mu dev e with e = sym L.
inline SymTensor<double> linear_elasticity(double kappa, double mu, const Tensor<double>& L) {
  const double volume = L(0, 0) + L(1, 1) + L(2, 2);
  SymTensor<double> tau;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      tau.c[symmetric_index(i, j)] = mu * (L(i, j) + L(j, i)) + (i == j ? (kappa - 2.0 / 3.0 * mu) * volume : 0.0);
  return tau;
}

/// The foam of the reference tables.
inline HerschelBulkley foam() { return {{200.0, 109000.0, 290.0, 31.9, 27.2, 0.22}}; }

}  // namespace bulkley::material_test
