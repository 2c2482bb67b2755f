#include "kernel/derived_fields.hpp"

#include <cmath>

#include "bulkley/base/tensor.hpp"

namespace bulkley {

namespace {

using Place = DerivedField::Place;

SymTensor<double> kirchhoff_stress(const Place& at) {
  SymTensor<double> tau = ParticleStress(at.particles, at.stress).of_one(at.p);
  // Under an implicit pressure or viscosity tau is what the law gives beside it.
  if (at.particles.has(Field::cell_mean_stress)) {
    const double spherical = at.particles.real(Field::volume_ratio)[at.p] * at.particles.real(Field::cell_mean_stress)[at.p];
    for (int a = 0; a < 3; ++a) tau.c[a] += spherical;
  }
  if (at.particles.has(Field::viscous_stress))
    for (int c = 0; c < 6; ++c) tau.c[c] += at.particles.real(Field::viscous_stress, c)[at.p];
  return tau;
}

double inverse_volume_ratio(const Place& at) { return 1.0 / at.particles.real(Field::volume_ratio)[at.p]; }

void pressure(const Place& at, double* out) { out[0] = -trace(kirchhoff_stress(at)) / 3.0 * inverse_volume_ratio(at); }

void deviatoric_stress(const Place& at, double* out) {
  out[0] = std::sqrt(norm_squared(deviator(kirchhoff_stress(at)))) * inverse_volume_ratio(at);
}

void cauchy_stress(const Place& at, double* out) {
  const SymTensor<double> tau = kirchhoff_stress(at);
  const double factor = inverse_volume_ratio(at);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) out[3 * a + b] = factor * tau(a, b);
}

void density(const Place& at, double* out) {
  const ParticleSet& particles = at.particles;
  out[0] = particles.densities()[particles.material()[at.p]] * inverse_volume_ratio(at);
}

void mass(const Place& at, double* out) { out[0] = at.particles.mass(at.p); }

void rank(const Place& at, double* out) { out[0] = at.rank; }

constexpr DerivedField table[] = {
    {"pressure", "Pa", "-tr(tau) / (3 J)", 1, false, pressure},
    {"deviatoric_stress", "Pa", "||dev tau|| / J", 1, false, deviatoric_stress},
    {"cauchy_stress", "Pa", "tau / J, row-major", 9, false, cauchy_stress},
    {"mass", "kg", "m_p = rho_0 V_p^0", 1, false, mass},
    {"density", "kg/m^3", "rho_0 / J", 1, false, density},
    {"rank", "1", "rank that holds the particle", 1, true, rank},  // the only one that depends on the number of ranks
};

}  // namespace

std::span<const DerivedField> derived_fields() { return table; }

}  // namespace bulkley
