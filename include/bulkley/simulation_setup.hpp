#pragma once
// From a scene to particles on their ranks.

#include <span>

#include "bulkley/domain/partition.hpp"
#include "bulkley/scene.hpp"
#include "bulkley/solver/solver.hpp"

namespace bulkley {

/// The part of a scene that the solver needs.
Physics physics_of(const Scene& scene);

/// The fields that the scene's particles have beside those that all have. Not collective.
OptionalFields optional_fields(const Scene& scene);

/// Particles per tile of the scene's bodies; each rank counts a share of the tiles. Collective.
std::vector<GlobalIndex> seeded_load(const Comm& comm, const Scene& scene);

/// Particles per tile of particles that any rank may hold; positions inside the domain. Collective.
std::vector<GlobalIndex> present_load(const Comm& comm, const GridGeometry& grid, const ParticleSet& particles);

/// The particles of the tiles that `partition` gives to this rank. Collective.
ParticleSet seed_share(const Comm& comm, const Scene& scene, const Partition& partition);

/// A solver at the scene's start: the partition is made first, from counted particles, so that no rank ever holds much more
/// than its share. Collective.
std::unique_ptr<Solver> start_solver(const Comm& comm, const Scene& scene);

}  // namespace bulkley
