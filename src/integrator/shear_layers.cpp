#include "integrator/shear_layers.hpp"

#include <algorithm>
#include <cmath>

#include "bulkley/base/pack.hpp"

namespace bulkley {

namespace {

constexpr double depths_of_sound = 8.0;  // over which pressures are means: two periods, of which 8 % are left

}  // namespace

ShearLayers::ShearLayers(const Physics& physics, LocalIndex block_size)
    : reach_((physics.transfer.order == SplineOrder::quadratic ? 1.5 : 2.0) * physics.grid.cell_size),
      fluids_(physics.materials.size()) {
  if (!physics.transfer.thin_layers) return;
  for (const Floor& floor : floors_of(physics.grid, physics.faces, physics.gravity))
    if (floor.kind == FaceKind::sticky) {
      floors_.push_back(floor);
      weights_.push_back(std::abs(physics.gravity[floor.axis]));
    }
  if (floors_.empty()) return;
  for (std::size_t m = 0; m < fluids_.size(); ++m) {
    const Material& material = physics.materials[m].material;
    if (!has_yield_stress(material)) continue;
    const std::optional<VolumetricLaw> law = physics.volumetric_laws.empty() ? volumetric_law(material) : std::nullopt;
    const double density = rest_density(material);
    fluids_[m] = Fluid{density, law, law ? std::sqrt(law->slope(1.0) / density) : 0.0};
    falls_.resize(static_cast<std::size_t>(block_size) + n_lanes);
  }
}

// Over the depth of a layer that its weight drives along a floor, stress and pressure fall in the same proportion, but for the pressure of sound
// that goes up and down in it. A particle stands for what lies between the floor and twice its height, and no more than the layer.
void ShearLayers::find(double dt, ParticleSet& particles, ParticleBlock block) {
  if (falls_.empty()) return;
  const LocalIndex end = std::min(block.end, particles.size());
  const double* const J = particles.real(Field::volume_ratio);
  const double* const cell_stress = particles.has(Field::cell_mean_stress) ? particles.real(Field::cell_mean_stress) : nullptr;
  double* const mean_pressure = particles.has(Field::layer_pressure) ? particles.real(Field::layer_pressure) : nullptr;
  const std::uint8_t* const material = particles.material();
  std::fill_n(falls_.begin(), end - block.begin, 0.0);
  for (std::size_t f = 0; f < floors_.size(); ++f) {
    const double* const x = particles.real(Field::position, floors_[f].axis);
    for (LocalIndex p = block.begin; p < end; ++p) {
      const double height = floors_[f].height(x[p]);
      if (height >= reach_ || height <= 0.0 || !fluids_[material[p]]) continue;
      const Fluid& fluid = *fluids_[material[p]];
      const double weight = fluid.density / J[p] * weights_[f];
      double pressure = -(fluid.volumetric ? fluid.volumetric->stress(J[p]) : cell_stress[p]);
      if (mean_pressure) {
        double& mean = mean_pressure[p];
        // Sound takes four depths a period, which are 4 mean / weight.
        if (mean > 0.0) mean += std::min(1.0, dt * fluid.sound_speed * weight / (depths_of_sound * mean)) * (pressure - mean);
        else mean = std::max(pressure, 0.0);
        pressure = mean;
      }
      if (!(pressure > 0.0)) continue;
      double& fall = falls_[static_cast<std::size_t>(p - block.begin)];
      fall = std::max(fall, std::min(0.5, weight * height / (weight * height + pressure)));
    }
  }
}

}  // namespace bulkley
