#pragma once

#include "scene/scene.hpp"
#include "simulation/forecast.hpp"

namespace bulkley {

/// The output of `check` for the meshes of bodies and colliders; nothing if there are none. Not collective.
void print_meshes(const Scene& scene, const Forecast& forecast);

}  // namespace bulkley
