#pragma once
// Reaches of the material, tables [[output.front]].

#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "scene/output_settings.hpp"

namespace bulkley {

/// The reach of a point, m; NaN if it does not count: a front with an eye sees only what is below the eye. Not collective.
double reach_of(const Front& front, const Vec3& position);

/// The reach of each front, m: the smallest reach of a particle such that particles that reach no farther have at least the
/// part `quantile` of the mass. NaN where no particle counts. The same bits on any number of ranks: it is the reach of one
/// particle, found by its bits with masses in integers (docs/theory.md, "Fronts"). Two reductions; with a quantile below 1,
/// ten. Collective.
std::vector<double> reaches(const Comm& comm, const std::vector<Front>& fronts, const ParticleSet& particles);

}  // namespace bulkley
