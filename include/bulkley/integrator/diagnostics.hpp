#pragma once
// Conserved and summary quantities of all particles.

#include "bulkley/base/types.hpp"

namespace bulkley {

struct Diagnostics {
  double mass = 0.0;                                ///< kg
  Vec3 momentum = Vec3::Zero();                     ///< kg m/s
  Vec3 angular_momentum = Vec3::Zero();             ///< kg m^2/s about the origin; with the affine part for APIC
  double kinetic_energy = 0.0;                      ///< J, of the particle velocities; with the affine part for APIC
  double elastic_energy = 0.0;                      ///< J
  double gravitational_energy = 0.0;                ///< J, -sum m g . x
  double dissipated_energy = 0.0;                   ///< J, by plastic flow since the start
  Vec3 center_of_mass = Vec3::Zero();               ///< m
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();  ///< m, bounding box of the positions
  double yielded_fraction = 0.0;  ///< mass that flowed plastically in the last step over mass of yielding materials
  double volume_error = 0.0;      ///< rms of J - 1 over the particles, weighted by their reference volumes
  GlobalIndex n_particles = 0;
};

}  // namespace bulkley
