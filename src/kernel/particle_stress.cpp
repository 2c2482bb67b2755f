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
  std::vector<double> shear(n_numbers, 0.0), half_bulk(n_numbers, 0.0);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const auto solid = neo_hookean_stress(materials[m].material);
    if (!solid) return;
    shear[m] = solid->parameters.shear_modulus;
    half_bulk[m] = 0.5 * solid->parameters.bulk_modulus;
  }
  shear_ = std::move(shear);
  half_bulk_ = std::move(half_bulk);
  uniform_ = materials.size() == 1;
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
  const std::uint8_t m = shear_.material[p];
  return elastic(stress, shear_.by_number[m], volumetric(half_bulk_.by_number[m], ratio_.column[0][p]));
}

}  // namespace bulkley
