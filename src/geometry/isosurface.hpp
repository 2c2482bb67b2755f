#pragma once
// Surfaces of functions, as triangles.

#include <functional>

#include "geometry/triangle_mesh.hpp"

namespace bulkley {

/// The surface of { x : f(x) < 0 } within the box from `lower` to `upper`, facing outwards: marching tetrahedra on a lattice
/// of at most `spacing` along each axis. Always closed: where the set meets the box, the box's face closes it. Vertices lie on
/// the lattice's edges, face diagonals and space diagonals by linear interpolation, and are shared by the triangles around
/// them. f is called once at each lattice point. Empty if f < 0 nowhere. Throws UsageError for a box without volume or a
/// spacing <= 0. Not collective.
TriangleMesh isosurface(const std::function<double(const Vec3&)>& f, const Vec3& lower, const Vec3& upper, double spacing);

}  // namespace bulkley
