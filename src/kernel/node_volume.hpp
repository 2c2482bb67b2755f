#pragma once
// How much material nodes near walls can hold.

#include <vector>

#include "grid/boundary.hpp"

namespace bulkley {

/// A node near walls and the part of its spline's volume that is in front of them, in (0, 1).
struct NodeVolume {
  LocalIndex node;  ///< index into the caller's node array
  double part;
};

/// The nodes that walls and colliders at rest take some of their splines' volume from, as if walls were plane: faces by what is behind
/// them and is not folded to the images in front; colliders by their distances, or where they act if that is behind their surfaces.
/// Material does not come far behind walls, so that no part is below a quarter. `nodes` as for node_constraints. Not collective.
std::vector<NodeVolume> node_volumes(const GridGeometry& grid, const Faces& faces, const std::vector<Collider>& colliders,
                                     const std::vector<Int3>& nodes);

}  // namespace bulkley
