#pragma once
// Faces of the domain on which material lies.

#include <vector>

#include "grid/face.hpp"
#include "grid/grid_geometry.hpp"

namespace bulkley {

struct Floor {
  int axis;
  double coordinate;  ///< m
  double upwards;     ///< 1 or -1 along the axis, out of the face
  double weight;      ///< gravity towards it, m/s^2
  FaceKind kind;

  /// Height of a particle over it, m.
  double height(double x) const { return upwards * (x - coordinate); }
};

/// The faces that hold material and are within 45 degrees of level, as gravity has it; none without gravity. Not collective.
std::vector<Floor> floors_of(const GridGeometry& grid, const Faces& faces, const Vec3& gravity);

/// How far over a floor particles feel the nodes that it holds, m. Not collective.
double reach_of_floors(const GridGeometry& grid, SplineOrder order);

}  // namespace bulkley
