#pragma once
// What a step learns about its particles: bounds for the next time step and for the order-free sums, and failures.
// Kernels fill one, ranks merge theirs in the one all-reduce of the step.

#include <algorithm>
#include <limits>

#include "bulkley/base/types.hpp"

namespace bulkley {

/// A largest value and the particle that has it; the smallest id wins ties, so the answer is the same on any rank count.
struct Extreme {
  double value = 0.0;
  GlobalIndex id = -1;

  void include(double other_value, GlobalIndex other_id) {
    if (other_value > value || (other_value == value && other_id >= 0 && (id < 0 || other_id < id))) {
      value = other_value;
      id = other_id;
    }
  }
  void include(const Extreme& other) { include(other.value, other.id); }
};

/// Maxima, minima and counters over particles. Plain data, merged member by member; every member is exact whatever the
/// order.
struct StepBounds {
  // For the next time step
  Extreme speed;                ///< max |v_p|, m/s
  Extreme wave_speed;           ///< max elastic wave speed c, m/s
  Extreme viscosity;            ///< max kinematic viscosity of a viscous stress, J eta / rho_0, m^2/s
  Extreme velocity_gradient;    ///< max ||L_p||_F, 1/s
  double collider_speed = 0.0;  ///< of moving colliders, m/s; known beforehand, so the solver sets it before each plan
  // For the order-free sums
  double mass = 0.0;           ///< max m_p, kg
  double momentum = 0.0;       ///< max m_p (|v_p| + |C_p| r), kg m/s, r = moment_sum_ratio dx
  double stress_volume = 0.0;  ///< max V_p^0 ||tau_p||, J
  GlobalIndex cell_count = 0;  ///< largest number of particles with one base cell
  // State
  double smallest_volume_ratio = std::numeric_limits<double>::infinity();
  double largest_volume_ratio = 0.0;
  GlobalIndex n_particles = 0;
  GlobalIndex largest_share = 0;  ///< particles of the rank that has most
  GlobalIndex n_removed = 0;      ///< left through an outflow face in this step
  GlobalIndex n_migrated = 0;     ///< moved to another rank in this step
  // Failures
  GlobalIndex n_not_finite = 0;
  GlobalIndex n_inverted = 0;                                       ///< det(1 + dt L) <= 0
  GlobalIndex n_escaped = 0;                                        ///< left the domain where no outflow is declared
  GlobalIndex failed_id = std::numeric_limits<GlobalIndex>::max();  ///< smallest id among the failures
  GlobalIndex n_undefined_nodes = 0;                                ///< where the acceleration field has no finite value
  GlobalIndex undefined_node = std::numeric_limits<GlobalIndex>::max();  ///< the first of them, z fastest
  // Requests
  std::int32_t needs_rebuild = 0;  ///< a particle entered a tile that the pools do not hold
  std::int32_t needs_sort = 0;     ///< a rank's particles have lost their order; all sort together, for all would wait
  std::int32_t stop_request = 0;   ///< signal or wall time, see Simulation

  bool failed() const { return n_not_finite + n_inverted + n_escaped + n_undefined_nodes > 0; }

  void merge(const StepBounds& other) {
    speed.include(other.speed);
    wave_speed.include(other.wave_speed);
    viscosity.include(other.viscosity);
    velocity_gradient.include(other.velocity_gradient);
    mass = std::max(mass, other.mass);
    momentum = std::max(momentum, other.momentum);
    stress_volume = std::max(stress_volume, other.stress_volume);
    cell_count = std::max(cell_count, other.cell_count);
    smallest_volume_ratio = std::min(smallest_volume_ratio, other.smallest_volume_ratio);
    largest_volume_ratio = std::max(largest_volume_ratio, other.largest_volume_ratio);
    n_particles += other.n_particles;
    largest_share = std::max(largest_share, other.largest_share);
    n_removed += other.n_removed;
    n_migrated += other.n_migrated;
    n_not_finite += other.n_not_finite;
    n_inverted += other.n_inverted;
    n_escaped += other.n_escaped;
    failed_id = std::min(failed_id, other.failed_id);
    n_undefined_nodes += other.n_undefined_nodes;
    undefined_node = std::min(undefined_node, other.undefined_node);
    needs_rebuild = std::max(needs_rebuild, other.needs_rebuild);
    needs_sort = std::max(needs_sort, other.needs_sort);
    stop_request = std::max(stop_request, other.stop_request);
  }
};

}  // namespace bulkley
