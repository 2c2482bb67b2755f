#pragma once
// Pool nodes -> particles, for one number per node.

#include <array>

#include "kernel/cells.hpp"

namespace bulkley {

/// value[p] = sum_i w_ip phi_i and gradient[axis][p] = sum_i phi_i (grad w_ip)[axis], by the B-splines' gradients whatever
/// the transfer of the step uses. `phi`: layout.n_nodes() numbers, placed as the Nodes of a pool (Exchange::get). Results:
/// by particle; null for those that are not wanted, of `gradient` all three or none. A particle's result does not depend on
/// the others. Preconditions as for scalar_deposit. Not collective.
void scalar_gather(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, const CellMap& map,
                   const double* phi, double* value, const std::array<double*, 3>& gradient);

}  // namespace bulkley
