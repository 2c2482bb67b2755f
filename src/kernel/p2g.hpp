#pragma once
// Particles -> pool nodes.

#include <optional>

#include "base/order_free.hpp"
#include "kernel/cell_means.hpp"
#include "kernel/cells.hpp"
#include "kernel/particle_stress.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

/// Rigorous bounds (T27) on what one node can receive, the same on every rank, and the rounding constants that follow.
struct SumBounds {
  double mass;      ///< kg, largest sum of absolute mass contributions to a node
  double momentum;  ///< kg m/s, with the impulse dt f included
  double impulse;   ///< kg m/s, dt f alone
};

/// A field of particles that holds a force on each, N, which nodes receive as sum w_ip F_p.
struct ParticleForce {
  Field field;
  double largest;  ///< N, of a component, over all ranks
};
using ForceField = std::optional<ParticleForce>;

/// Where the impulses of the internal forces go.
enum class Impulses {
  joined,  ///< into the momentum of a Node
  apart,   ///< into the second node of a NodePair, for schemes that need the velocity before the forces
  both     ///< into both nodes of a NodePair; the first is what `joined` gives, to rounding
};

/// From the merged bounds of the previous step and the time step to come. `splits`: momenta are without impulses
/// (Impulses::apart); `means`: p2g gets CellMeans. Not collective.
SumBounds sum_bounds(const GridGeometry& grid, const TransferSettings& transfer, const StepBounds& bounds, double dt,
                     bool splits, const ForceField& force = {}, bool means = false);

/// Sums mass and momentum of all particles into `pool` (zeroed here; layout.n_nodes() nodes):
///   m_i = sum w m_p (T4),  (m v)_i = sum w m_p (v_p + C_p (x_i - x_p)) (T5), C_p only where the transfer is affine,
/// and the impulse dt f_i of the internal forces ((T11) or (T12), as `transfer` says), with it dt sum w F_p of `force`. A Node
/// joins both; of a NodePair, `impulses` (apart or both) says it. `sums` must be of the same choice.
/// The mean stress of a particle is that of its group in `means`. Reads position, velocity,
/// affine_velocity, mass, reference_volume, the force, and kirchhoff_stress or what `stress` needs for it. Every contribution is rounded for
/// order-free sums. Not collective.
void p2g(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const ParticleSet& particles,
         const CellMap& map, const SumBounds& sums, double dt, Node* pool, const ForceField& force = {},
         const CellMeans& means = {}, const StressOfState& stress = {});
void p2g(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const ParticleSet& particles,
         const CellMap& map, const SumBounds& sums, double dt, NodePair* pool, const ForceField& force = {},
         Impulses impulses = Impulses::apart, const CellMeans& means = {}, const StressOfState& stress = {});

}  // namespace bulkley
