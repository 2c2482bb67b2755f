#include "integrator/shear_layers.hpp"

#include <algorithm>
#include <cmath>

#include "bulkley/base/pack.hpp"

namespace bulkley {

ShearLayers::ShearLayers(const Physics& physics, LocalIndex block_size)
    : grid_(physics.grid),
      reach_((physics.transfer.order == SplineOrder::quadratic ? 1.5 : 2.0) * physics.grid.cell_size),
      fluids_(physics.materials.size()) {
  if (!physics.transfer.thin_layers) return;
  for (const Floor& floor : floors_of(physics))
    if (floor.kind == FaceKind::sticky) {
      floors_.push_back(floor);
      weights_.push_back(std::abs(physics.gravity[floor.axis]));
    }
  if (floors_.empty()) return;
  for (std::size_t m = 0; m < fluids_.size(); ++m) {
    const Material& material = physics.materials[m].material;
    if (!has_yield_stress(material)) continue;
    fluids_[m] = Fluid{rest_density(material), physics.volumetric_laws.empty() ? volumetric_law(material) : std::nullopt};
    falls_.resize(static_cast<std::size_t>(block_size) + n_lanes);
  }
}

// Over the depth of a layer that its weight drives along a floor, stress and pressure fall in the same proportion. A particle stands
// for what lies between the floor and twice its height, and no more than the layer.
void ShearLayers::find(const ParticleSet& particles, ParticleBlock block) {
  if (falls_.empty()) return;
  const LocalIndex end = std::min(block.end, particles.size());
  const double* const J = particles.real(Field::volume_ratio);
  const double* const cell_stress = particles.has(Field::cell_mean_stress) ? particles.real(Field::cell_mean_stress) : nullptr;
  const std::uint8_t* const material = particles.material();
  std::fill_n(falls_.begin(), end - block.begin, 0.0);
  for (std::size_t f = 0; f < floors_.size(); ++f) {
    const double* const x = particles.real(Field::position, floors_[f].axis);
    for (LocalIndex p = block.begin; p < end; ++p) {
      const double height = floors_[f].height(x[p]);
      if (height >= reach_ || height <= 0.0 || !fluids_[material[p]]) continue;
      const Fluid& fluid = *fluids_[material[p]];
      const double pressure = -(fluid.volumetric ? fluid.volumetric->stress(J[p]) : cell_stress[p]);
      if (!(pressure > 0.0)) continue;
      const double below = fluid.density / J[p] * weights_[f] * height;
      double& fall = falls_[static_cast<std::size_t>(p - block.begin)];
      fall = std::max(fall, std::min(0.5, below / (below + pressure)));
    }
  }
}

}  // namespace bulkley
