#include "kernel/particle_stress.hpp"

namespace bulkley {

std::vector<NamedMaterial> explicit_materials(std::span<const NamedMaterial> materials, bool implicit_pressure,
                                              bool implicit_viscosity) {
  std::vector<NamedMaterial> rest(materials.begin(), materials.end());
  for (NamedMaterial& named : rest) {
    if (implicit_pressure) named.material = without_volumetric_law(named.material);
    if (implicit_viscosity) named.material = without_viscosity(named.material);
  }
  return rest;
}

StressOfState::StressOfState(std::span<const NamedMaterial> materials) {
  std::vector<double> shear, half_bulk;
  for (const NamedMaterial& named : materials) {
    const auto solid = neo_hookean_stress(named.material);
    if (!solid) return;
    shear.push_back(solid->parameters.shear_modulus);
    half_bulk.push_back(0.5 * solid->parameters.bulk_modulus);
  }
  any_ = true;
  shear_ = ByMaterial(shear);
  half_bulk_ = ByMaterial(half_bulk);
}

StressOfState::StressOfState(const ParticleSet& particles, std::span<const NamedMaterial> scene_materials) {
  if (particles.has(Field::kirchhoff_stress)) return;
  *this = StressOfState(explicit_materials(scene_materials, particles.has(Field::cell_mean_stress),
                                           particles.has(Field::viscous_stress)));
}

SymTensor<double> ParticleStress::of_one(LocalIndex p) const {
  SymTensor<double> stress;
  for (int c = 0; c < 6; ++c) stress.c[c] = components_.column[c][p];
  if (!from_state_) return stress;
  return elastic(stress, shear_.one(p), volumetric(half_bulk_.one(p), ratio_.column[0][p]));
}

}  // namespace bulkley
