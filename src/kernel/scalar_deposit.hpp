#pragma once
// Particles -> pool nodes, for one number per particle.

#include "kernel/cells.hpp"

namespace bulkley {

/// s_i = sum_p w_ip q_p into `pool` (zeroed here; layout.n_nodes() numbers, placed as the Nodes of a pool; Exchange::add
/// brings the copies together). `q`: by particle, finite. `largest`: of |q| over all particles of all ranks; `cell_count`:
/// the largest number of particles with one base cell on any rank (StepBounds, sums.cell_count). Every contribution is rounded
/// for order-free sums: the same bits for any order of the particles and any division among ranks; each is off by at most
/// 2^-54 scalar_sum_bound. Preconditions: positions inside the domain, `map` located in `layout`. Not collective.
void scalar_deposit(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, const CellMap& map,
                    const double* q, double largest, GlobalIndex cell_count, double* pool);

/// Bound of sum_p |w_ip q_p| at any node, all ranks together (T27). Not collective.
double scalar_sum_bound(SplineOrder order, double largest, GlobalIndex cell_count);

}  // namespace bulkley
