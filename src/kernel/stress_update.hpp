#pragma once
// Constitutive update of all particles of one material.

#include <span>

#include "bulkley/particle/particle_set.hpp"
#include "kernel/cell_means.hpp"
#include "kernel/step_bounds.hpp"
#include "material/material.hpp"

namespace bulkley {

/// What is known of the room that particles have, by particle of the block; null: nothing.
struct Room {
  const double* fullness = nullptr;  ///< the mass around it over what there is room for
  const double* missing = nullptr;   ///< how much less than full it is there, where there should be no room
};

/// Advances the particles with material index `material_index` in `block` by dt.
/// Reads velocity gradient (field `gradient`: affine_velocity or velocity_gradient), left_cauchy_green, volume_ratio, the law's
/// internal variables, reference_volume, id; of particles of a group in `means` the trace of the velocity gradient is the group's, and
/// the volume ratio relaxes towards the group's first. The volume ratio of a law that flows then follows `room` (docs/theory.md,
/// (V5), (V6)); of a fluid with a yield stress, `fall` by particle of the block, or null: the part of it by which the stress falls across the
/// particle's layer (T13f). Writes left_cauchy_green, volume_ratio, internal variables, kirchhoff_stress if particles store it, and, where the
/// law flows, plastic_shear_rate and plastic_dissipation. Merges
/// into `bounds`: wave_speed, viscosity, stress_volume, smallest/largest_volume_ratio, n_not_finite, n_inverted, failed_id. A
/// particle that fails (det(1 + dt L) <= 0, or a result that is not finite) is counted once and keeps its state. Other materials are
/// not touched. The bits of a particle's result depend on that particle, its room, its fall and its group's means alone. Requires dt > 0.
/// Not collective.
void stress_update(const Material& material, std::uint8_t material_index, Field gradient, double dt, ParticleSet& particles,
                   StepBounds& bounds, ParticleBlock block = {}, const CellMeans& means = {},
                   const Room& room = {}, const double* fall = nullptr);

/// The fields that particles of these materials need for internal variables and, unless it follows from their strain, their stress. Not
/// collective.
OptionalFields internal_fields(std::span<const NamedMaterial> materials);

/// The densities that particles of these materials have. Not collective.
Densities densities_of(std::span<const NamedMaterial> materials);

/// Gives the internal variables of the material's particles their values at the start. Not collective.
void set_internal_variables(const Material& material, std::uint8_t material_index, ParticleSet& particles);

/// Gives particles that store it the stress of their strain, kirchhoff_stress(state) of their law. Not collective.
void set_stress(std::span<const NamedMaterial> materials, ParticleSet& particles);

/// The state of one particle, which must be of this law. Not collective.
template <class Law>
State<double, n_internal<Law>> particle_state(const Law&, const ParticleSet& particles, LocalIndex p) {
  constexpr int n = n_internal<Law>;
  State<double, n> state;
  for (int c = 0; c < 6; ++c) state.left_cauchy_green.c[c] = particles.real(Field::left_cauchy_green, c)[p];
  state.volume_ratio = particles.real(Field::volume_ratio)[p];
  if constexpr (n > 0) {
    int k = 0;
    for (const Field variable : Law::internal)
      for (int c = 0; c < info(variable).n_components; ++c) state.internal[k++] = particles.real(variable, c)[p];
  }
  return state;
}

/// The states of particles, a pack at a time. `particles` must outlive this. Not collective.
template <class Law>
class StateColumns {
 public:
  StateColumns(const Law& law, const ParticleSet& particles)
      : left_cauchy_green_(particles, Field::left_cauchy_green),
        volume_ratio_(particles, Field::volume_ratio),
        rest_(state_at_rest(law)) {
    [[maybe_unused]] int k = 0;
    for (const Field variable : Law::internal)
      for (int c = 0; c < info(variable).n_components; ++c) internal_[k++] = particles.real(variable, c);
  }

  /// Of n_lanes particles from `p` on. Other lanes than `mine` have that of a particle at rest: cheap, and free of their material's or the
  /// padding's numbers.
  State<Pack, n_internal<Law>> of(LocalIndex p, PackMask mine) const {
    State<Pack, n_internal<Law>> state;
    for (int c = 0; c < 6; ++c)
      state.left_cauchy_green.c[c] = select(mine, left_cauchy_green_(p, c), broadcast<Pack>(c < 3 ? 1.0 : 0.0));
    state.volume_ratio = select(mine, volume_ratio_(p), broadcast<Pack>(1.0));
    if constexpr (n_internal<Law> > 0)
      for (int k = 0; k < n_internal<Law>; ++k)
        state.internal[k] = select(mine, load(internal_[k] + p), broadcast<Pack>(rest_.internal[k]));
    return state;
  }

 private:
  FieldColumns<6> left_cauchy_green_;
  FieldColumns<1> volume_ratio_;
  State<double, n_internal<Law>> rest_;
  const double* internal_[n_internal<Law> + 1] = {};
};

}  // namespace bulkley
