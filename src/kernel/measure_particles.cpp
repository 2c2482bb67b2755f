#include "kernel/measure_particles.hpp"

#include <algorithm>

#include "kernel/batch.hpp"

namespace bulkley {

void measure_particles(const GridGeometry& grid, const TransferSettings& transfer, const ParticleSet& particles,
                       StepBounds& bounds) {
  const MassColumn masses(particles);
  const LocalIndex count = particles.size();
  for (LocalIndex p = 0; p < count; p += n_lanes) {
    const int n = static_cast<int>(std::min<LocalIndex>(n_lanes, count - p));
    const GlobalIndex* id = particles.id() + p;
    Pack v[3], affine[9];
    for (int r = 0; r < 3; ++r) v[r] = load(particles.real(Field::velocity, r) + p);
    for (int c = 0; c < 9; ++c) affine[c] = load(particles.real(Field::affine_velocity, c) + p);
    const Pack speed_squared = squares(v), affine_squared = squares(affine);
    Pack reach = square_root(speed_squared);
    if (transfer.affine()) reach += square_root(affine_squared) * (moment_sum_ratio(grid.order) * grid.cell_size);
    const Pack mass = masses(p);
    include_lanes(bounds.motion.speed, speed_squared, id, n);
    include_lanes(bounds.motion.velocity_gradient, affine_squared, id, n);
    for (int lane = 0; lane < n; ++lane) {
      bounds.sums.mass.include(mass[lane]);
      bounds.sums.momentum.include(mass[lane] * reach[lane]);
    }
  }
}

}  // namespace bulkley
