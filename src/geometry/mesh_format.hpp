#pragma once
// Triangle meshes from the bytes of OBJ, STL and PLY files. Bytes of any kind end in a mesh or in a sentence.

#include <optional>
#include <string>
#include <string_view>

#include "geometry/triangle_mesh.hpp"

namespace bulkley {

enum class MeshFormat { obj, stl, ply };

/// By the extension of a file's name, in any case of letters; none if it is another.
std::optional<MeshFormat> mesh_format(const std::string& file_name);

/// The faces, ASCII or binary, polygons cut into triangles; coordinates as the file has them. Neither welded nor checked,
/// but indices are those of vertices. Throws UsageError, a sentence that continues after the file's name. Not collective.
TriangleMesh parse_mesh(std::string_view bytes, MeshFormat format);

}  // namespace bulkley
