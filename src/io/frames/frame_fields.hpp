#pragma once
// The arrays of a frame: stored and derived quantities of particles, the grid, and the tiles.

#include "io/arrays/particle_array.hpp"
#include "io/frames/frame.hpp"
#include "kernel/particle_stress.hpp"

namespace bulkley {

/// `rank`: this one; `stress` must outlive the array. Throws UsageError for an unknown name.
Array frame_array(const std::string& name, FloatPrecision precision, const ParticleRange& range,
                  const ParticleSet& particles, std::int32_t rank, const StressOfState& stress);

/// /grid/mass_density and /grid/velocity, (nz, ny, nx) and (nz, ny, nx, 3).
std::vector<Array> grid_arrays(const GridNodes& nodes, FloatPrecision precision);

/// /tiles/rank, /tiles/particles and /tiles/load, (nz, ny, nx) of tiles; each rank writes a part of the z-planes.
std::vector<Array> tile_arrays(const Comm& comm, const TileValues& tiles);

}  // namespace bulkley
