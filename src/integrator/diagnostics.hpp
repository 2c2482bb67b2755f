#pragma once
// Conserved and summary quantities of all particles, measured.

#include "bulkley/integrator/diagnostics.hpp"
#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "integrator/physics.hpp"

namespace bulkley {

/// What particle p stores, J: the energy of its law and, under an implicit pressure p, V p^2 / (2 kappa). Not collective.
double elastic_energy(const Physics& physics, const ParticleSet& particles, LocalIndex p);

/// The same bits on any number of ranks: sums are BinnedSums, rounded once. One pass in blocks, without memory for each particle. Collective.
Diagnostics diagnose(const Comm& comm, const Physics& physics, const ParticleSet& particles);

}  // namespace bulkley
