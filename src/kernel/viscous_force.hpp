#pragma once
// The Newtonian stress of particles as an operator on node velocities (docs/theory.md, "Implicit viscosity"), and its record on
// the particles.

#include <span>
#include <vector>

#include "kernel/cells.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

/// 2 eta J V of every particle, J s, then ParticleSet::padding zeros. `viscosities`: eta by material, Pa s. Returns the largest.
/// Not collective.
double set_viscous_weights(std::span<const double> viscosities, const ParticleSet& particles, std::vector<double>& weights);

/// Bound (T27) on the sum of the absolute contributions below to one node, N. `largest_weight`: over the particles of all ranks;
/// `largest_speed`: over the nodes of all ranks, m/s; `cell_count`: StepBounds, sums.cell_count. Not collective.
double viscous_force_bound(const GridGeometry& grid, const TransferSettings& transfer, GlobalIndex cell_count,
                           double largest_weight, double largest_speed);

/// Forces f_i = -sum_p weight_p dev sym L_p G_ip, N, of the velocities v of the nodes into `force` (zeroed here): L_p = sum_i v_i
/// G_ip^T, with G = grad w or D^-1 w (x_i - x_p) as `transfer` says; the same G in both places makes the operator symmetric.
/// `velocity`, `force`: layout.n_nodes() of {x, y, z, -}. Every contribution is rounded for order-free sums within `bound`.
/// Preconditions: positions inside the domain, `map` located in `layout`. Not collective.
void viscous_forces(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const ParticleSet& particles, const double* weights, double bound, const Node* velocity, Node* force);

/// Sets `viscous_stress` of the particles of `block` to 2 eta J dev sym L, L being their field `gradient`, and adds its work in a
/// step of dt, s, to their dissipation. Not collective.
void record_viscous_stress(std::span<const double> viscosities, Field gradient, double dt, ParticleSet& particles,
                           ParticleBlock block);

}  // namespace bulkley
