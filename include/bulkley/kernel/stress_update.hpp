#pragma once
// Constitutive update of all particles of one material.

#include "bulkley/kernel/step_bounds.hpp"
#include "bulkley/material/material.hpp"
#include "bulkley/particle/particle_set.hpp"

namespace bulkley {

/// Advances the particles with material index `material_index` in `block` by dt.
/// Reads velocity gradient (field `gradient`: affine_velocity or velocity_gradient), left_cauchy_green, volume_ratio,
/// reference_volume, id. Writes left_cauchy_green, volume_ratio, kirchhoff_stress, and, where the law flows, plastic_shear_rate and plastic_dissipation. Merges into `bounds`: wave_speed, stress_volume, smallest/largest_volume_ratio, n_not_finite,
/// n_inverted, failed_id. A particle that fails (det(1 + dt L) <= 0, or a result that is not finite) is counted once and
/// keeps its state. Other materials are not touched. The bits of a particle's result depend on that particle alone.
/// Requires dt > 0. Not collective.
void stress_update(const Material& material, std::uint8_t material_index, Field gradient, double dt, ParticleSet& particles,
                   StepBounds& bounds, ParticleBlock block = {});

}  // namespace bulkley
