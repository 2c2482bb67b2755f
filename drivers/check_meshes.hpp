#pragma once

#include "bulkley/forecast.hpp"
#include "bulkley/scene.hpp"

namespace bulkley {

/// What `check` says of the meshes of bodies and colliders; nothing if there are none. Not collective.
void print_meshes(const Scene& scene, const Forecast& forecast);

}  // namespace bulkley
