#include "kernel/transfer.hpp"

#include <cmath>

#include "kernel/bspline.hpp"

namespace bulkley {

double TransferSettings::decay_rate(double cell_size, const MotionBounds& motion, double shear_wave_speed) const {
  if (damping_time > 0.0) return 1.0 / damping_time;
  if (scheme != TransferScheme::moment_flip) return 0.0;
  const double crossing = (shear_wave_speed + motion.viscosity.value / cell_size) / cell_size;
  return motion.velocity_gradient.value / damping_strain + crossing / damping_distance;
}

double TransferSettings::kept_share(double dt, double rate) const {
  switch (scheme) {
    case TransferScheme::flip:
      return 1.0;
    case TransferScheme::blend:
      return damping_time > 0.0 ? std::exp(-dt * rate) : flip_ratio;
    case TransferScheme::moment_flip:
      return std::exp(-dt * rate);
    case TransferScheme::pic:
    case TransferScheme::apic:
      break;
  }
  return 0.0;
}

double affine_inertia(const GridGeometry& grid, const TransferSettings& transfer) {
  return transfer.affine() ? grid.cell_size * grid.cell_size / inverse_second_moment(grid.order) : 0.0;
}

}  // namespace bulkley
