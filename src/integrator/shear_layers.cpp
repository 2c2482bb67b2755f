#include "integrator/shear_layers.hpp"

#include <algorithm>

#include "bulkley/base/pack.hpp"

namespace bulkley {

ShearLayers::ShearLayers(const Physics& physics, LocalIndex block_size)
    : reach_(reach_of_floors(physics.grid, physics.transfer.order)), densities_(physics.materials.size()) {
  if (!physics.transfer.thin_layers) return;
  floors_ = floors_of(physics.grid, physics.faces, physics.gravity);
  std::erase_if(floors_, [](const Floor& floor) { return floor.kind != FaceKind::sticky; });
  if (floors_.empty()) return;
  for (std::size_t m = 0; m < densities_.size(); ++m)
    if (has_yield_stress(physics.materials[m].material)) {
      densities_[m] = rest_density(physics.materials[m].material);
      falls_.resize(static_cast<std::size_t>(block_size) + n_lanes);
    }
}

// Over the depth of a layer that its weight drives along a floor, stress and pressure fall in the same proportion. A particle stands for what
// lies between the floor and twice its height, and no more than the layer.
void ShearLayers::find(const ParticleSet& particles, ParticleBlock block, const double* pressures) {
  if (falls_.empty()) return;
  const LocalIndex end = std::min(block.end, particles.size());
  const double* const J = particles.real(Field::volume_ratio);
  const std::uint8_t* const material = particles.material();
  std::fill_n(falls_.begin(), end - block.begin, 0.0);
  for (const Floor& floor : floors_) {
    const double* const x = particles.real(Field::position, floor.axis);
    for (LocalIndex p = block.begin; p < end; ++p) {
      const double height = floor.height(x[p]), pressure = pressures[p - block.begin];
      if (height >= reach_ || height <= 0.0 || !(pressure > 0.0)) continue;
      const double weight = densities_[material[p]] / J[p] * floor.weight;
      double& fall = falls_[static_cast<std::size_t>(p - block.begin)];
      fall = std::max(fall, std::min(0.5, weight * height / (weight * height + pressure)));
    }
  }
}

}  // namespace bulkley
