#pragma once
// Surfaces of shapes as triangles, for visualization; the solver uses only their signed distance.

#include "geometry/shape.hpp"
#include "geometry/triangle_mesh.hpp"

namespace bulkley {

/// Triangles of the surface of `shape`, facing outwards.
///
/// Vertices lie on the surface: boxes, planes and triangle meshes are exact, round shapes have 48 segments to a turn. A
/// union is the surfaces of its parts, which may pass through each other. Complements and differences are traced on a
/// lattice of 64 cells along the longest side, which blunts edges by up to a cell. What has no bounds is drawn as far as it
/// lies within `window`, whose faces close it. Not collective.
TriangleMesh surface_of(const Shape& shape, const Bounds& window);

}  // namespace bulkley
