#pragma once
// Shapes that hold meshes: filling them with triangles, in the size and place given in the scene.

#include <functional>
#include <string>

#include "geometry/mesh_solid.hpp"
#include "geometry/shape.hpp"

namespace bulkley {

/// Whether the shape, or a part of it, is a mesh that has no triangles yet. Not collective, as all functions here.
bool waits_for_mesh(const Shape& shape);

/// Calls visit(mesh) for each mesh in the shape, in its order.
void visit_meshes(const Shape& shape, const std::function<void(const Mesh&)>& visit);

/// The shape with each mesh replaced by replacement(mesh).
Shape with_meshes(const Shape& shape, const std::function<Mesh(const Mesh&)>& replacement);

/// Welds triangles as a file gives them. Throws UsageError, a sentence that continues after the file's name, if they are no
/// mesh: indices without a vertex, coordinates that are not finite, no triangle with an area.
WeldCount weld_checked(TriangleMesh& triangles);

/// `mesh` with its solid made of `triangles` (welded), rotated, scaled and moved as the mesh specifies. Throws UsageError,
/// as above, if it encloses nothing.
Mesh filled(const Mesh& mesh, TriangleMesh triangles);

/// The shape with its meshes by sampled distances (sampled_distance.hpp), for the many lookups of colliders on a grid with
/// this cell size. Throws UsageError, as above, for a mesh too large for such cells.
Shape sampled_for_contact(const Shape& shape, double cell_size);

}  // namespace bulkley
