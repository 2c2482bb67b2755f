#pragma once
// From what a step has counted to the error that ends the run.

#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "grid/grid_geometry.hpp"
#include "kernel/step_bounds.hpp"
#include "material/material.hpp"
#include "stepping/failure.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

/// What went wrong in a step whose merged `bounds` have failed(): how many particles, and the one with the smallest id; or
/// the first node that the acceleration field has left without a value. Collective.
[[noreturn]] void throw_failure(const Comm& comm, const GridGeometry& grid, const ParticleSet& particles,
                                const std::vector<NamedMaterial>& materials, const StepBounds& bounds);

/// `reason` and the particle that it names: id, material, position, speed, volume ratio. Collective.
[[noreturn]] void throw_failure(const Comm& comm, const ParticleSet& particles, const std::vector<NamedMaterial>& materials,
                                const NoStep& reason);

/// Throws NoStep if particles may not continue from a step of `dt` seconds, although they are finite: volume ratios beyond
/// the bounds of the settings, or a speed of more than a cell a step. `bounds`: merged over ranks, after the step.
/// Collective.
void check_motion(const Comm& comm, const TimeStepSettings& settings, double cell_size, double dt,
                  const ParticleSet& particles, const StepBounds& bounds);

}  // namespace bulkley
