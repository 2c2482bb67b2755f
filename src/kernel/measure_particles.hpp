#pragma once
// What a time step needs to know of particles that no step has measured yet.

#include "bulkley/particle/particle_set.hpp"
#include "grid/grid_geometry.hpp"
#include "kernel/step_bounds.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

/// Merges speed, mass and momentum of the particles as they are, and velocity_gradient as it is stored. For the first step.
/// Not collective.
void measure_particles(const GridGeometry& grid, const TransferSettings& transfer, const ParticleSet& particles,
                       StepBounds& bounds);

}  // namespace bulkley
