#pragma once
// Triangle meshes from files.

#include <string>

#include "geometry/triangle_mesh.hpp"

namespace bulkley {

/// The faces of an OBJ, STL or PLY file, ASCII or binary, polygons cut into triangles, coordinates in the unit of the
/// file. Neither welded nor checked. Throws UsageError, a sentence that continues after the file's name, if it cannot
/// be read. Not collective.
TriangleMesh read_mesh_file(const std::string& path);

}  // namespace bulkley
