#pragma once
// The program's particles as the reference sees them.

#include <algorithm>
#include <span>
#include <vector>

#include "bulkley/base/tensor.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "kernel/particle_stress.hpp"
#include "support/reference_mpm.hpp"

namespace bulkley {

inline Mat3 full_matrix(const ParticleSet& set, Field field, LocalIndex p) {
  Mat3 result;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) result(a, b) = set.real(field, 3 * a + b)[p];
  return result;
}

inline Mat3 symmetric_matrix(const ParticleSet& set, Field field, LocalIndex p) {
  Mat3 result;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) result(a, b) = set.real(field, symmetric_index(a, b))[p];
  return result;
}

/// A copy of all particles, ascending by id; `materials` as of a step, for stresses that are not stored. L is velocity_gradient where the set has it of all particles, else affine_velocity.
inline std::vector<ReferenceParticle> reference_particles(const ParticleSet& set, std::span<const NamedMaterial> materials) {
  const StressOfState of_state(set, materials);
  const ParticleStress stress(set, of_state);
  std::vector<ReferenceParticle> result;
  for (LocalIndex p = 0; p < set.size(); ++p) {
    ReferenceParticle r;
    r.x = set.vector(Field::position, p);
    r.v = set.vector(Field::velocity, p);
    r.C = full_matrix(set, Field::affine_velocity, p);
    r.L = set.has(Field::velocity_gradient) && set.holds_all(Field::velocity_gradient) ? full_matrix(set, Field::velocity_gradient, p) : r.C;
    r.b = symmetric_matrix(set, Field::left_cauchy_green, p);
    r.J = set.real(Field::volume_ratio)[p];
    r.m = set.mass(p);
    r.V = set.real(Field::reference_volume)[p];
    const SymTensor<double> tau = stress.of_one(p);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) r.tau(a, b) = tau(a, b);
    r.shear_rate = set.real(Field::plastic_shear_rate)[p];
    r.dissipation = set.real(Field::plastic_dissipation)[p];
    r.material = set.material()[p];
    r.id = set.id()[p];
    result.push_back(r);
  }
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return result;
}

}  // namespace bulkley
