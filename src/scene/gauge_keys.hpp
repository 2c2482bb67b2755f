#pragma once
// What [[output.front]] and [[output.gauge]] have to agree on with the rest of a scene.

#include "bulkley/config/value.hpp"
#include "scene/scene.hpp"

namespace bulkley {

/// Finds materials and colliders by their names, and refuses what measures nothing: faces without a wall, names that another
/// group of columns has. Not collective.
void join_measurements(const config::Value& root, Scene& scene, config::Faults& faults);

}  // namespace bulkley
