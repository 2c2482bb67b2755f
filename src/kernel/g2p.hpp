#pragma once
// Pool nodes -> particles.

#include "kernel/cells.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

/// Updates velocity (T6, T7), affine_velocity (C_p = B_p D_p^-1, (T8), damped by (T9); also kept, unused by p2g, where the
/// transfer is not affine but L_p is read from it), velocity_gradient where the transfer needs it, and position (T10): x_p
/// += dt v_pic, always with the interpolated grid velocity. `velocity`: v_i after forces and boundaries; `change`: v_i
/// minus its value before forces, read when flip_fraction > 0. Merges speed, velocity_gradient, mass and momentum into
/// `bounds`. Only particles of `block`. Not collective.
void g2p(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map, double dt,
         const Node* velocity, const Node* change, ParticleSet& particles, StepBounds& bounds, ParticleBlock block = {});

/// What g2p would find, without touching a particle: merges velocity_gradient, speed (of the interpolated velocity) and
/// not-finite particles into `bounds`. Judges a time step before it is taken. Not collective.
void measure_motion(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const Node* velocity, const ParticleSet& particles, StepBounds& bounds);

/// Merges speed, mass and momentum of the particles as they are, and velocity_gradient as it is stored. For the first step.
/// Not collective.
void measure_particles(const GridGeometry& grid, const TransferSettings& transfer, const ParticleSet& particles,
                       StepBounds& bounds);

}  // namespace bulkley
