#pragma once
// The arrays of a frame: stored and derived quantities of particles, and the grid.

#include "bulkley/io/frame.hpp"
#include "particle_array.hpp"

namespace bulkley {

/// Throws UsageError for an unknown name.
Array frame_array(const std::string& name, FloatPrecision precision, const ParticleRange& range,
                  const ParticleSet& particles);

/// /grid/mass_density and /grid/velocity, (nz, ny, nx) and (nz, ny, nx, 3).
std::vector<Array> grid_arrays(const GridNodes& nodes, FloatPrecision precision);

}  // namespace bulkley
