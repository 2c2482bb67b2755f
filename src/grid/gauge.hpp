#pragma once
// Patches of walls on which the force of the material is measured, tables [[output.gauge]].

#include <optional>
#include <string>
#include <vector>

#include "grid/boundary.hpp"

namespace bulkley {

/// The faces by name, in the order of Faces.
enum class FaceName { x_lower, x_upper, y_lower, y_upper, z_lower, z_upper };

/// A part of a face or of a collider's surface: what of it lies within a box, within a ball, or all of it. On a collider that
/// moves, the patch moves along; it is given where the scene file puts the collider.
struct Gauge {
  std::string name;
  std::optional<FaceName> face;
  std::optional<std::string> collider;
  std::optional<Vec3> lower, upper;  ///< m, corners of a box along the axes
  std::optional<Vec3> center;        ///< m, of a ball
  std::optional<double> radius;      ///< m, of the ball: on a face, of a disc around the centre
  int collider_number = -1;          ///< of `collider` in the scene; -1: a face
  std::string place;                 ///< "file:line:column" in the scene, for messages
};

/// The part of the wall around a node that belongs to the patch of a gauge on a face, 0 to 1. The wall is divided among the
/// nodes on it in squares of one cell, as far as they lie in the domain; nodes outside the domain count with the nearest one
/// inside. Not collective.
double face_share(const GridGeometry& grid, const Gauge& gauge, const Int3& node);

/// The like for a gauge on a collider, for a node at `position` (m) that the collider holds while it is at `pose`: the part
/// of a square of one cell, tangential to the surface at its point nearest to the node, sampled at 64 points. Not collective.
double collider_share(const GridGeometry& grid, const Gauge& gauge, const Collider& collider, const Pose& pose,
                      const Vec3& position);

/// Area of a patch, m^2. On a face exact; on a collider that of triangles, with flat pieces for round shapes (surface_of),
/// and without what lies outside the domain unless the collider moves. Not collective.
double gauge_area(const GridGeometry& grid, const Gauge& gauge, const std::vector<Collider>& colliders);

/// Number of nodes on the face that have a share in the patch of a gauge on a face. Not collective.
GlobalIndex count_gauge_nodes(const GridGeometry& grid, const Gauge& gauge);

}  // namespace bulkley
