#pragma once
// Pool nodes -> particles.

#include "kernel/cells.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

/// What g2p leaves besides, by particle of a block, with n_lanes entries more than it has; null: nothing. The first two are of a fourth
/// quantity n_i of the nodes.
struct Gathered {
  double* value = nullptr;           ///< sum_i w_ip n_i
  double* slope[3] = {};             ///< along an axis, per cell: by the transfer's moments, if it has them, or by the spline's gradient
  double* kinetic_energy = nullptr;  ///< J, of the new motion, with that of C_p where the transfer is affine (affine_inertia)
};

/// Updates velocity (T6, T7), affine_velocity (C_p = B_p D_p^-1, (T8), damped by (T9); also kept, unused by p2g, where the
/// transfer is not affine but L_p is read from it), velocity_gradient where the transfer needs it, and position (T10): x_p
/// += dt v_pic, always with the interpolated grid velocity. Merges speed, velocity_gradient, mass and momentum into `bounds`. Only
/// particles of `block`. `nodes`: {v_i, n_i} after forces and boundaries; `gathered`: where to leave more.
/// Precondition: !transfer.keeps_residual(). Not collective.
void g2p(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map, double dt,
         const Node* nodes, ParticleSet& particles, StepBounds& bounds, ParticleBlock block = {},
         const Gathered& gathered = {});
/// The same for transfers that keep the share `kept_share` of the residual (T7), and of both residuals with (T9b). `nodes`: {v_i, n_i}
/// and {v_i minus its value before forces, -}. Precondition: transfer.keeps_residual(). Not collective.
void g2p(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map, double dt,
         double kept_share, const NodePair* nodes, ParticleSet& particles, StepBounds& bounds, ParticleBlock block = {},
         const Gathered& gathered = {});

/// What g2p would find, without touching a particle: merges velocity_gradient, speed (of the interpolated velocity) and
/// not-finite particles into `bounds`. Judges a time step before it is taken. Particles of tiles whose nodes show by their
/// differences (T26c) that all stay within `ample` are left out; nodes without mass, n_i = 0, take no part in that. Not collective.
void measure_motion(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const Node* nodes, const ParticleSet& particles, StepBounds& bounds, const MotionLimits& ample = {});
void measure_motion(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const NodePair* nodes, const ParticleSet& particles, StepBounds& bounds, const MotionLimits& ample = {});

}  // namespace bulkley
