#pragma once
// The background grid's index arithmetic: nodes, tiles, and which tile a particle belongs to.
//
// Nodes. Along a periodic axis there are `n_cells` nodes, node I at lower + I dx, and indices wrap; where it has one cell, all
// nodes of a stencil are that node, and nothing changes along it: a plane flow. Along any other axis
// there are n_cells + 4, node I at lower + (I - 1) dx: one below the domain and three above, so that every stencil of a
// particle inside the domain (faces included) exists. Tile T covers nodes 4 T .. 4 T + 3 per axis.
// A particle belongs to the tile of the first ("base") node of its stencil.

#include <cmath>

#include "bulkley/base/types.hpp"

namespace bulkley {

inline constexpr int tile_width = 4;                                     ///< nodes per tile and axis
inline constexpr int tile_nodes = tile_width * tile_width * tile_width;  ///< nodes (and base cells) per tile

using TileIndex = std::int32_t;  ///< linear index of a tile, z fastest

/// B-spline degree of the transfers.
enum class SplineOrder : int { quadratic = 2, cubic = 3 };

/// Nodes per axis in one particle's stencil: 3 or 4.
constexpr int stencil_width(SplineOrder order) { return static_cast<int>(order) + 1; }
/// Nodes per axis that the particles of one tile reach: 6 or 7.
constexpr int footprint_width(SplineOrder order) { return tile_width + static_cast<int>(order); }

/// The uniform background grid over an axis-aligned box.
struct GridGeometry {
  Vec3 lower = Vec3::Zero();  ///< m
  double cell_size = 0.0;     ///< dx, m
  Int3 n_cells{0, 0, 0};      ///< per axis; 1 or a multiple of tile_width along periodic axes
  std::array<bool, 3> periodic{false, false, false};
  SplineOrder order = SplineOrder::quadratic;

  double inverse_cell_size() const { return 1.0 / cell_size; }
  Vec3 upper() const { return lower + cell_size * Vec3(n_cells[0], n_cells[1], n_cells[2]); }
  /// Index of the node at `lower`.
  int node_offset(int axis) const { return periodic[axis] ? 0 : 1; }
  int n_nodes(int axis) const { return periodic[axis] ? n_cells[axis] : n_cells[axis] + 4; }
  int n_tiles(int axis) const { return (n_nodes(axis) + tile_width - 1) / tile_width; }
  TileIndex n_tiles() const { return n_tiles(0) * n_tiles(1) * n_tiles(2); }
  /// Whether nothing changes along this axis.
  bool is_plane(int axis) const { return periodic[axis] && n_cells[axis] == 1; }
  /// The node along one axis that `index` is in a footprint, which goes on beyond the end of a periodic axis; n_nodes or more where
  /// there is none. Along the axis of a plane flow no stencil reaches beyond the first stencil_width.
  int wrapped(int axis, int index) const {
    if (is_plane(axis)) return index < stencil_width(order) ? 0 : index;
    return periodic[axis] && index >= n_cells[axis] ? index - n_cells[axis] : index;
  }
  double node_coordinate(int axis, int index) const { return lower[axis] + (index - node_offset(axis)) * cell_size; }
  Vec3 node_position(const Int3& n) const {
    return {node_coordinate(0, n[0]), node_coordinate(1, n[1]), node_coordinate(2, n[2])};
  }
  /// Number of a node among all, z fastest, and the node of a number.
  GlobalIndex node_number(const Int3& n) const {
    return (static_cast<GlobalIndex>(n[0]) * n_nodes(1) + n[1]) * n_nodes(2) + n[2];
  }
  Int3 node_of_number(GlobalIndex number) const {
    const GlobalIndex nz = n_nodes(2), ny = n_nodes(1);
    return {static_cast<int>(number / (ny * nz)), static_cast<int>(number / nz % ny), static_cast<int>(number % nz)};
  }

  /// Distance from the base node to the particle's cell origin, in cells: base = floor(xi - shift) + node_offset.
  double base_shift() const { return order == SplineOrder::quadratic ? 0.5 : 1.0; }

  /// Index of the base node along one axis, wrapped if periodic. Precondition: lower <= coordinate <= upper.
  int base_node(int axis, double coordinate) const {
    const double xi = (coordinate - lower[axis]) * inverse_cell_size();
    int base = static_cast<int>(std::floor(xi - base_shift())) + node_offset(axis);
    if (periodic[axis]) {
      if (base < 0) base += n_cells[axis];
      if (base >= n_cells[axis]) base -= n_cells[axis];
    }
    return base;
  }

  TileIndex tile_index(const Int3& tile) const { return (tile[0] * n_tiles(1) + tile[1]) * n_tiles(2) + tile[2]; }
  Int3 tile_coordinates(TileIndex tile) const {
    const int nz = n_tiles(2), ny = n_tiles(1);
    return {tile / (ny * nz), (tile / nz) % ny, tile % nz};
  }
  TileIndex tile_of_node(const Int3& node) const {
    return tile_index({node[0] / tile_width, node[1] / tile_width, node[2] / tile_width});
  }
  /// The tile that a particle at `position` belongs to. Precondition: inside the domain.
  TileIndex tile_of(const Vec3& position) const {
    return tile_of_node({base_node(0, position[0]), base_node(1, position[1]), base_node(2, position[2])});
  }
  /// Number of its base node within that tile, z fastest.
  int place_in_tile(const Vec3& position) const {
    int place = 0;
    for (int axis = 0; axis < 3; ++axis) place = place * tile_width + base_node(axis, position[axis]) % tile_width;
    return place;
  }
  /// The tile `step` (-1, 0 or 1 along each axis) from `tile`, around periodic axes; -1 where there is none.
  TileIndex neighbour(const Int3& tile, const Int3& step) const {
    Int3 there;
    for (int axis = 0; axis < 3; ++axis) {
      const int n = n_tiles(axis);
      there[axis] = tile[axis] + step[axis];
      if (periodic[axis]) there[axis] = (there[axis] + n) % n;
      if (there[axis] < 0 || there[axis] >= n) return -1;
    }
    return tile_index(there);
  }
};

}  // namespace bulkley
