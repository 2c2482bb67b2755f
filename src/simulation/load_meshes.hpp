#pragma once
// The meshes of a scene, from their files to every rank.

#include "bulkley/parallel/comm.hpp"
#include "scene/scene.hpp"

namespace bulkley {

enum class MeshesOf { everything, colliders };

/// Fills the scene's meshes. The root reads each file once and sends the triangles to all; every rank makes its own solids
/// of them. Throws UsageError with the place in the scene, the file and what is wrong with it. Collective.
void load_meshes(const Comm& comm, Scene& scene, MeshesOf which);

}  // namespace bulkley
