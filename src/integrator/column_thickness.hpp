#pragma once
// How many cells thick the material is.

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "grid/grid_geometry.hpp"

namespace bulkley {

/// A tenth of the material's volume is in columns of cells, along the axis nearest to gravity, that hold no more than this
/// many cells of material; the volume is that of the undeformed material, what lies above each other counts together. NaN
/// without gravity or particles. `lower`, `upper`: bounds of all particles' positions, the same on every rank. The same bits
/// on any number of ranks: volumes are summed as integers, in 2^-40 of a cell. Known on the root alone, NaN elsewhere; one
/// reduction of 8 bytes a column within the bounds. Collective.
double thickness_decile(const Comm& comm, const GridGeometry& grid, const Vec3& gravity, const ParticleSet& particles,
                        const Vec3& lower, const Vec3& upper);

}  // namespace bulkley
