#include "integrator/floor_pressure.hpp"

#include <algorithm>
#include <cmath>

#include "bulkley/base/pack.hpp"

namespace bulkley {

namespace {

constexpr double depths_of_sound = 8.0;  // over which pressures are means: two periods, of which 8 % are left

}  // namespace

FloorPressure::FloorPressure(const Physics& physics, LocalIndex block_size)
    : reach_(reach_of_floors(physics.grid, physics.transfer.order)), fluids_(physics.materials.size()) {
  floors_ = floors_of(physics.grid, physics.faces, physics.gravity);
  if (floors_.empty()) return;
  for (std::size_t m = 0; m < fluids_.size(); ++m) {
    const Material& material = physics.materials[m].material;
    const bool fills = physics.transfer.close_voids && physics.keeps_volume_of_cells(m);
    const bool shears = physics.transfer.thin_layers && has_yield_stress(material);
    if (!flows(material) || !(fills || shears)) continue;
    const std::optional<VolumetricLaw> law = physics.volumetric_laws.empty() ? volumetric_law(material) : std::nullopt;
    const double density = rest_density(material);
    fluids_[m] = Fluid{density, law, law ? std::sqrt(law->slope(1.0) / density) : 0.0};
    pressures_.resize(static_cast<std::size_t>(block_size) + n_lanes);
  }
}

void FloorPressure::find(double dt, ParticleSet& particles, ParticleBlock block) {
  if (pressures_.empty()) return;
  const LocalIndex end = std::min(block.end, particles.size());
  const double* const J = particles.real(Field::volume_ratio);
  const double* const cell_stress = particles.has(Field::cell_mean_stress) ? particles.real(Field::cell_mean_stress) : nullptr;
  double* const means = particles.has(Field::layer_pressure) ? particles.real(Field::layer_pressure) : nullptr;
  const std::uint8_t* const material = particles.material();
  std::fill_n(pressures_.begin(), end - block.begin, 0.0);
  for (const Floor& floor : floors_) {
    const double* const x = particles.real(Field::position, floor.axis);
    for (LocalIndex p = block.begin; p < end; ++p) {
      if (std::abs(floor.height(x[p])) >= reach_ || !fluids_[material[p]]) continue;
      const Fluid& fluid = *fluids_[material[p]];
      double pressure = -(fluid.volumetric ? fluid.volumetric->stress(J[p]) : cell_stress[p]);
      if (means) {
        double& mean = means[p];
        // Sound takes four depths a period, which are 4 mean / weight.
        const double weight = fluid.density / J[p] * floor.weight;
        if (mean > 0.0) mean += std::min(1.0, dt * fluid.sound_speed * weight / (depths_of_sound * mean)) * (pressure - mean);
        else mean = std::max(pressure, 0.0);
        pressure = mean;
      }
      pressures_[static_cast<std::size_t>(p - block.begin)] = pressure;
    }
  }
}

}  // namespace bulkley
