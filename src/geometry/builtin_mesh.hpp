#pragma once
// Figures that the project makes itself, so that a scene with a mesh runs without a file.

#include <string>
#include <vector>

#include "geometry/triangle_mesh.hpp"

namespace bulkley {

/// What a mesh's `file` begins with if it names one of these figures.
inline constexpr const char* builtin_prefix = "builtin:";

/// Their names without the prefix.
const std::vector<std::string>& builtin_meshes();

/// A closed, curved figure that is not convex: the isosurface of a smooth union of ellipsoids and capsules. Some 0.15 m large,
/// y up, the snout towards -x. Throws UsageError for an unknown name. Not collective.
TriangleMesh builtin_mesh(const std::string& name);

}  // namespace bulkley
