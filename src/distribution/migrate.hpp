#pragma once
// Particles -> the owner of their tile.

#include <span>

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "distribution/neighbours.hpp"

namespace bulkley {

/// A particle that has to move.
struct Departure {
  LocalIndex particle;
  std::int32_t rank;
};

/// Sends the particles of `departures` (each particle at most once, `rank` a neighbour) to their ranks with all fields that
/// move, removes them here (the last particles fill the gaps), and appends the arrivals, ordered by source rank. A message goes
/// to each neighbour, empty or not, and nobody else is waited for. Nothing is lost: the global number of particles is
/// unchanged. Between neighbours: each of them must call it. Returns the number of particles received.
LocalIndex migrate(const Comm& comm, const Neighbours& neighbours, std::span<const Departure> departures,
                   ParticleSet& particles);

}  // namespace bulkley
