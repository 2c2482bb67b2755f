#pragma once
// Scene keys of free rigid bodies.

#include "bulkley/config/keys.hpp"
#include "scene/scene.hpp"

namespace bulkley {

const config::Keys<RigidBody>& keys(config::Of<RigidBody>);

/// What rigid bodies and other tables have to agree on: names of columns, and an integrator that takes bodies.
void join_rigid_bodies(const config::Value& root, Scene& scene, config::Faults& faults);

}  // namespace bulkley
