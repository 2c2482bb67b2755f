#include "integrator/cell_dilation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bulkley {

namespace {

// Volume ratios of a cell's particles go to their mean within the time in which the fastest wave crosses so many cells.
constexpr double cells_to_relax = 10.0;

}  // namespace

CellDilation::CellDilation(StepParts& parts, const StressOfState& stress)
    : parts_(parts), stress_(stress), least_density_(std::numeric_limits<double>::infinity()) {
  const Physics& physics = parts.physics;
  for (std::size_t m = 0; m < physics.materials.size(); ++m) {
    place_of_.push_back(physics.shares_dilation[m] ? n_sharing_++ : -1);
    if (!physics.shares_dilation[m]) continue;
    const double density = rest_density(physics.materials[m].material);
    least_density_ = std::min(least_density_, density);
  }
  by_cell_ = physics.materials.size() == 1 && physics.feeds.empty();
}

CellGroups CellDilation::groups() const { return by_cell_ ? CellGroups(parts_.particles.map().cell) : CellGroups(groups_); }

CellSumBounds CellDilation::bounds() const {
  const StepBounds& known = parts_.particles.bounds();
  return {known.sums.mass / least_density_, known.sums.stress_volume, std::max(known.totals.largest_volume_ratio.value, 1.0),
          known.sums.cell_count};
}

void CellDilation::begin(double time, double dt) {
  const ParticleSet& particles = parts_.particles.particles();
  const std::vector<LocalIndex>& cell = parts_.particles.map().cell;
  if (!by_cell_) {
    groups_.assign(cell.size(), -1);
    for (LocalIndex p = 0; p < particles.size(); ++p)
      if (const int place = place_of_[particles.material()[p]]; place >= 0)
        groups_[static_cast<std::size_t>(p)] = cell[static_cast<std::size_t>(p)] * n_sharing_ + place;
    for_each_carried(parts_.physics, time, particles,
                     [&](std::size_t, LocalIndex p) { groups_[static_cast<std::size_t>(p)] = -1; });
  }
  renew(sums_, parts_.particles.map().count.size() * static_cast<std::size_t>(n_sharing_));
  sum_stress(particles, groups(), bounds(), sums_, stress_);
  take_means_of_stress(sums_);
  const double crossing = parts_.particles.bounds().motion.wave_speed.value / parts_.physics.grid.cell_size;
  relaxation_ = -std::expm1(-dt * crossing / cells_to_relax);
}

}  // namespace bulkley
