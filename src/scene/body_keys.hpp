#pragma once
// Keys of [[bodies]] of a scene.

#include "bulkley/config/keys.hpp"
#include "particle/seeding.hpp"

namespace bulkley {

config::Names<SeedingLattice> names(config::Of<SeedingLattice>);

/// Leaves material_index and density to the caller.
const config::Keys<Body>& keys(config::Of<Body>);

}  // namespace bulkley
