#pragma once
// Pool nodes -> particles, for numbers per node.

#include <array>

#include "kernel/cells.hpp"

namespace bulkley {

/// What particles are to receive of a field: layout.n_nodes() numbers, placed as the Nodes of a pool (Exchange::get), and where to,
/// by particle; nothing where `nodes` is null.
struct GatheredValue {
  const double* nodes = nullptr;
  double* to = nullptr;
};
struct GatheredGradient {
  const double* nodes = nullptr;
  std::array<double*, 3> to{};
};

/// value.to[p] = sum_i w_ip phi_i and gradient.to[axis][p] = sum_i psi_i (grad w_ip)[axis], phi and psi being the fields of the two, by
/// the B-splines' gradients whatever the transfer of the step uses. A particle's result does not depend on the others.
/// Preconditions as for scalar_deposit. Not collective.
void scalar_gather(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, const CellMap& map,
                   const GatheredValue& value, const GatheredGradient& gradient);

}  // namespace bulkley
