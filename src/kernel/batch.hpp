#pragma once
// Shared by p2g and g2p: particles are processed in batches, first lane-parallel (one pack a time: weights and per-particle
// algebra), then particle by particle with one 4-wide vector {x, y, z, mass} per node.

#include <cstring>

#include "bulkley/base/pack.hpp"
#include "bulkley/kernel/bspline.hpp"
#include "bulkley/kernel/cells.hpp"

namespace bulkley {

using Quad [[gnu::vector_size(32)]] = double;  ///< the four numbers of a Node

inline Quad load_quad(const Node& node) {
  Quad q;
  std::memcpy(&q, node.c, sizeof q);
  return q;
}

inline constexpr int batch_size = 32;  ///< small enough that a batch's scratch stays in the first-level cache
static_assert(batch_size % n_lanes == 0 && batch_size <= ParticleSet::padding);

/// Forces a product to be rounded, so that the compiler cannot fuse it into a following sum: base nodes must come out here
/// exactly as GridGeometry::base_node gives them.
inline void keep_rounded(Pack& value) { asm("" : "+m"(value)); }

/// Distance of each particle above its base node, in cells, along one axis.
inline Pack offset_in_stencil(const GridGeometry& grid, int axis, Pack coordinate) {
  Pack xi = (coordinate - grid.lower[axis]) * grid.inverse_cell_size();
  keep_rounded(xi);
  return xi - round_down(xi - grid.base_shift());
}

/// Row offsets of one particle's stencil: `row(i, j)` is the pool index of node (i, j, 0).
template <SplineOrder order>
class StencilRows {
 public:
  StencilRows(const LocalIndex* row_offsets, LocalIndex cell) {
    constexpr int w = footprint_width(order);
    const int local = cell % tile_nodes;
    base_ = row_offsets + static_cast<std::ptrdiff_t>(cell / tile_nodes) * (w * w) +
            (local / (tile_width * tile_width)) * w + (local / tile_width) % tile_width;
    z_ = local % tile_width;
  }
  LocalIndex operator()(int i, int j) const { return base_[i * footprint_width(order) + j] + z_; }

 private:
  const LocalIndex* base_;
  LocalIndex z_;
};

/// Calls `function` with the spline order as a compile-time constant.
template <class Function>
void with_order(SplineOrder order, Function function) {
  if (order == SplineOrder::quadratic)
    function(std::integral_constant<SplineOrder, SplineOrder::quadratic>{});
  else
    function(std::integral_constant<SplineOrder, SplineOrder::cubic>{});
}

}  // namespace bulkley
