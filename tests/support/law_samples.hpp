#pragma once
// Materials of every law, and random states that their particles can be in.

#include <Eigen/Dense>
#include <limits>
#include <ostream>
#include <random>
#include <vector>

#include "support/random_vectors.hpp"
#include "unit/material/support.hpp"

namespace bulkley::material_test {

struct LawSample {
  const char* id;
  Material material;
  double speed_of_flow;  ///< 1/s: at this rate of deformation and dt = 1e-3 some steps flow and some do not
};
inline void PrintTo(const LawSample& sample, std::ostream* out) { *out << sample.id; }

inline HerschelBulkley::Parameters with_background(HerschelBulkley::Parameters p, double viscosity) {
  p.background_viscosity = viscosity;
  return p;
}

inline ThixotropicHerschelBulkley thixotropic_foam() {
  ThixotropicHerschelBulkley::Parameters p{foam().parameters};
  p.build_up = 0.5;
  p.breakdown = 0.2;
  return {p};
}

inline ThixotropicHerschelBulkley rheopectic_fluid() {
  ThixotropicHerschelBulkley::Parameters p{{1000.0, 1e5, 1e4, 100.0, 10.0, 1.4, 2.0}};
  p.kinetics = ThixotropicHerschelBulkley::Kinetics::rheopectic;
  p.build_up = 0.3;
  p.breakdown = 2.0;
  p.rate_exponent = 1.3;
  p.yield_exponent = 2.0;
  p.consistency_exponent = 0.5;
  p.residual_yield = 0.1;
  p.initial_structure = 0.2;
  return {p};
}

/// Loses all of its yield stress and consistency with the structure, which starts at 0.
inline ThixotropicHerschelBulkley unstructured_fluid() {
  ThixotropicHerschelBulkley::Parameters p{foam().parameters};
  p.build_up = 100.0;
  p.breakdown = 10.0;
  p.yield_exponent = 1.5;
  p.consistency_exponent = 0.7;
  p.initial_structure = 0.0;
  return {p};
}

/// The sand of the reference checks: E = 3.537e5 Pa, nu = 0.3.
inline DruckerPrager reference_sand(double friction_angle = 30.0) {
  DruckerPrager::Parameters p{from_youngs_modulus(2200.0, 3.537e5, 0.3)};
  p.friction_angle = friction_angle;
  return {p};
}

inline DruckerPrager hardening_sand() {
  DruckerPrager sand = reference_sand(35.0);
  sand.parameters.hardening_rise = 9.0;
  sand.parameters.hardening_decay = 0.2;
  sand.parameters.hardening_drop = 10.0;
  return sand;
}

inline DruckerPrager cohesive_sand() {
  DruckerPrager sand = reference_sand(25.0);
  sand.parameters.cohesion = 2000.0;
  return sand;
}

/// Stomakhin's: E = 1.4e5 Pa, nu = 0.2.
inline Snow reference_snow() { return {{from_youngs_modulus(400.0, 1.4e5, 0.2), 2.5e-2, 7.5e-3, 10.0}}; }

inline FiniteViscoelastic reference_viscoelastic() {
  return {{{1000.0, 1e5, 2e3}, 1000.0, 1500.0 + 2.0 / 3.0 * 1000.0, 0.025, 80.0 / (2.0 * (1500.0 + 2.0 / 3.0 * 1000.0))}};
}

inline std::vector<LawSample> law_samples() {
  using Form = OldroydB::Form;
  const HerschelBulkley::Parameters bingham{1000.0, 1e5, 1e4, 30.0, 10.0, 1.0};
  return {
      {"neo_hookean", NeoHookean{{1100.0, 1e5, 2.5e4}}, 100.0},
      {"hencky", Hencky{{1100.0, 1e5, 2.5e4}}, 100.0},
      {"hencky_soft_volume", Hencky{{1100.0, 1e4, 2.5e4}}, 100.0},
      {"fixed_corotated", FixedCorotated{{1100.0, 1e5, 2.5e4}}, 100.0},
      {"fixed_corotated_negative_lambda", FixedCorotated{{1100.0, 1e4, 2.5e4}}, 100.0},
      {"herschel_bulkley", foam(), 30.0},
      {"herschel_bulkley_background", HerschelBulkley{with_background(bingham, 3.0)}, 10.0},
      {"newtonian", Newtonian{{1000.0, 1e5, 2.0}}, 30.0},
      {"newtonian_linear", Newtonian{{1000.0, 1e5, 2.0, 1.0}}, 30.0},
      {"newtonian_without_tension", Newtonian{{1000.0, 1e5, 2.0, 7.0, false}}, 30.0},
      {"oldroyd_b", OldroydB{{1000.0, 1e5, 500.0, 0.01, 1.5}}, 30.0},
      {"oldroyd_b_isochoric", OldroydB{{1000.0, 1e5, 500.0, 0.01, 0.0, Form::isochoric}}, 30.0},
      {"finite_viscoelastic", reference_viscoelastic(), 30.0},
      {"thixotropic", thixotropic_foam(), 30.0},
      {"rheopectic", rheopectic_fluid(), 10.0},
      {"unstructured", unstructured_fluid(), 30.0},
      {"sand", reference_sand(), 3.0},
      {"hardening_sand", hardening_sand(), 3.0},
      {"cohesive_sand", cohesive_sand(), 10.0},
      {"snow", reference_snow(), 10.0},
  };
}

/// Moves a state as if nothing flowed, the elastic part of an internal variable along.
template <class Law, int n>
void move_elastically(const Law&, State<double, n>& state, const Tensor<double>& L, double dt) {
  if constexpr (std::is_same_v<Law, FiniteViscoelastic>) {
    Tensor<double> f;
    for (int c = 0; c < 9; ++c) f.c[c] = dt * L.c[c] + (c % 4 == 0 ? 1.0 : 0.0);
    SymTensor<double> branch;
    for (int c = 0; c < 6; ++c) branch.c[c] = state.internal[c];
    branch = push_forward(f, branch);
    for (int c = 0; c < 6; ++c) state.internal[c] = branch.c[c];
  }
  deform(static_cast<State<double>&>(state), L, dt);
}

/// A state that the law itself reaches: strained at once, to stretches about 1 +- strain, then let flow over some steps.
template <class Law, class Random>
State<double, n_internal<Law>> reachable_state(const Law& law, Random& random, double strain) {
  while (true) {
    State<double, n_internal<Law>> state = state_at_rest(law);
    const Tensor<double> L = random_tensor(random, strain);
    Tensor<double> f = L;
    for (int a = 0; a < 3; ++a) f(a, a) += 1.0;
    if (determinant(f) < 0.3 || determinant(f) > 3.0) continue;
    move_elastically(law, state, L, 1.0);
    for (int step = 0; step < 3; ++step) law.update(state, random_tensor(random, strain), 1e-2);
    return state;
  }
}

inline Tensor<double> tensor(const Eigen::Matrix3d& m) {
  Tensor<double> t;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) t(i, j) = m(i, j);
  return t;
}
inline Eigen::Matrix3d matrix(const Tensor<double>& t) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = t(i, j);
  return m;
}
inline Eigen::Matrix3d matrix(const SymTensor<double>& t) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = t(i, j);
  return m;
}

/// The state seen by a turned observer.
template <class Law, int n>
State<double, n> rotated(const Law&, State<double, n> state, const Tensor<double>& rotation) {
  state.left_cauchy_green = push_forward(rotation, state.left_cauchy_green);
  if constexpr (std::is_same_v<Law, FiniteViscoelastic>) {
    SymTensor<double> branch;
    for (int c = 0; c < 6; ++c) branch.c[c] = state.internal[c];
    branch = push_forward(rotation, branch);
    for (int c = 0; c < 6; ++c) state.internal[c] = branch.c[c];
  }
  return state;
}

/// c^2 rho at rest, which is kappa for a fluid, is near it for every law; Pa.
template <class Law>
double bulk_stiffness(const Law& law) {
  if constexpr (requires { law.parameters.bulk_modulus; })
    return law.parameters.bulk_modulus;
  else
    return law.wave_speed_squared(state_at_rest(law)) * law.density();
}

/// Whether everything that the kernel checks is finite.
template <int n>
bool is_finite(const State<double, n>& state, const Update<double>& update) {
  double sum = std::fabs(state.volume_ratio) + std::fabs(update.plastic_shear_rate) + std::fabs(update.dissipation);
  for (int c = 0; c < 6; ++c) sum += std::fabs(state.left_cauchy_green.c[c]) + std::fabs(update.kirchhoff_stress.c[c]);
  if constexpr (n > 0)
    for (const double variable : state.internal) sum += std::fabs(variable);
  return std::isfinite(sum);
}

}  // namespace bulkley::material_test
