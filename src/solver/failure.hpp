#pragma once
// The sentence about particles that failed.

#include <string>
#include <vector>

#include "bulkley/base/parallel.hpp"
#include "bulkley/kernel/step_bounds.hpp"
#include "bulkley/base/tile.hpp"
#include "bulkley/material/material.hpp"
#include "bulkley/particle/particle_set.hpp"

namespace bulkley {

/// What went wrong in a step whose merged `bounds` have failed(): how many particles, and id, position, speed and material
/// of the one with the smallest id; or the first node that the acceleration field has left without a value. The same text on
/// every rank. Collective.
std::string describe_failure(const Comm& comm, const GridGeometry& grid, const ParticleSet& particles,
                             const std::vector<NamedMaterial>& materials, const StepBounds& bounds);

}  // namespace bulkley
