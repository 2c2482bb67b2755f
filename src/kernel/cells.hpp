#pragma once
// Which cell of which pool tile each particle is in, and the physical order of particles.

#include <span>
#include <vector>

#include "bulkley/particle/particle_set.hpp"
#include "grid/boundary.hpp"
#include "grid/node_pool.hpp"
#include "kernel/step_bounds.hpp"
#include "particle/census.hpp"

namespace bulkley {

/// For every particle: slot of its tile in the pool * tile_nodes + its base node within the tile (row-major, z fastest).
struct CellMap {
  std::vector<LocalIndex> cell;   ///< by particle, then ParticleSet::padding entries that kernels may read
  std::vector<LocalIndex> count;  ///< particles by cell
  LocalIndex n_jumps = 0;         ///< particles that are in another tile than the one before them

  /// Room for `n_particles` in the cells of `layout`; none is counted yet.
  void reset(const PoolLayout& layout, LocalIndex n_particles);
  /// Room for `n_particles`, the first of them as before.
  void resize(LocalIndex n_particles);
  LocalIndex largest_count() const;
};

/// A particle that is not in a tile of this rank's pool.
struct OutsideParticle {
  LocalIndex particle;
  TileIndex tile;
};

/// Brings positions back into the domain: wraps periodic axes, puts particles that have crossed a wall by less than half a
/// cell back onto it. Particles beyond an outflow face are appended to `removed` (ascending); beyond any other face they
/// count as escaped, and not-finite positions as such (`bounds`), and stay where they are. Only particles of `block`. Not
/// collective.
void confine(const GridGeometry& grid, const Faces& faces, ParticleSet& particles, std::vector<LocalIndex>& removed,
             StepBounds& bounds, ParticleBlock block = {});

/// Finds the cells of the particles of `block` and counts them there; particles in tiles outside the pool get cell 0, are
/// not counted and are appended to `outside`. Preconditions: `map` was reset for `layout` and has room for the particles,
/// each is counted once; positions inside the domain. Not collective.
void locate(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, CellMap& map,
            std::vector<OutsideParticle>& outside, ParticleBlock block = {});

/// What each tile holds. Precondition: positions inside the domain, materials below `n_materials`. Not collective.
TileCensus take_census(const GridGeometry& grid, const ParticleSet& particles, int n_materials);

/// Bit d = 9 (a + 1) + 3 (b + 1) + (c + 1): a particle in one of the occupied cells (TileCensus::cells) of a tile may enter
/// the neighbour (a, b, c) of the tile by moving one cell, or is in it already.
std::uint32_t reach_of(std::uint64_t cells);

/// Calls visit(there) for the tiles that reach_of names. Not collective.
template <class Visit>
void visit_reach(const GridGeometry& grid, const Int3& tile, std::uint64_t cells, Visit visit) {
  const std::uint32_t reach = reach_of(cells);
  for (int d = 0; d < 27; ++d)
    if (reach >> d & 1)
      if (const TileIndex there = grid.neighbour(tile, {d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1}); there >= 0) visit(there);
}

/// The tiles that visit_reach finds from the tiles of the census; ascending. Not collective.
std::vector<TileIndex> tiles_in_reach(const GridGeometry& grid, const TileCensus& census);

/// Physically sorts particles by tile and cell, and `map` with them. Not collective.
void sort_particles(ParticleSet& particles, CellMap& map);

}  // namespace bulkley
