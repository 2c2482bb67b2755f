#pragma once
// Bodies -> particles. Which particles exist, where, and their ids follow from geometry alone, never from the rank count.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bulkley/particle/particle_set.hpp"
#include "config/formula.hpp"
#include "geometry/shape.hpp"
#include "grid/grid_geometry.hpp"
#include "particle/census.hpp"

namespace bulkley {

enum class SeedingLattice { regular, jittered };

/// One piece of material at the start, an entry of [[bodies]].
struct Body {
  std::string name;
  Shape shape;
  std::string material;                  ///< name of an entry of [materials]
  std::uint8_t material_index = 0;       ///< its position in the scene
  double density = 0.0;                  ///< kg/m^3, from the material
  Vec3 velocity = Vec3::Zero();          ///< m/s
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, about `center`
  std::optional<Vec3> center;            ///< m, default: centre of the shape's bounds
  VectorFormula velocity_field;          ///< m/s, of x, y, z; added to the two
  int particles_per_cell = 8;            ///< 1, 8, 27 or 64: a cubic lattice in each cell
  SeedingLattice lattice = SeedingLattice::regular;
  std::uint64_t seed = 0;  ///< jittered: the offset of a particle is a hash of seed, cell and place in the cell
};

/// What `bodies` put into the tiles with first <= index < last. Throws UsageError as seed_particles. Not collective.
TileCensus count_particles(const GridGeometry& grid, const std::vector<Body>& bodies, TileIndex first, TileIndex last);

/// The velocity at the start and its gradient: `velocity`, the spin and `velocity_field` of a body.
class StartMotion {
 public:
  StartMotion(const GridGeometry& grid, const Body& body);
  Vec3 velocity(const Vec3& position);
  Mat3 gradient(const Vec3& position);

 private:
  Vec3 velocity_, angular_velocity_, center_;
  double step_;  ///< m, of the differences that make the gradient
  std::optional<VectorField> field_;
};

/// Particles in a full cell: `particles_per_cell`, or one layer of them in a plane flow. Throws UsageError if that is not 1, 8, 27 or
/// 64. Not collective.
int particles_in_cell(const GridGeometry& grid, const Body& body);

/// A particle whose `velocity_field` has no finite value or gradient.
struct UndefinedMotion {
  std::size_t body;
  Vec3 position;  ///< m
};
/// The first such particle in the tiles with first <= index < last, in their order; none if all is well. Visits nothing where no
/// body has a `velocity_field`. Not collective.
std::optional<UndefinedMotion> find_undefined_motion(const GridGeometry& grid, const std::vector<Body>& bodies,
                                                     TileIndex first, TileIndex last);

/// Appends the particles of `bodies` whose tile is in `tiles` (ascending), tile by tile: reserve room for them. Sets position, velocity, affine_velocity (the
/// gradient of the velocity), left_cauchy_green = 1, volume_ratio = 1, mass, reference_volume, material and id; stress and
/// plastic fields zero. Lattice points lie at lower + (cell + (a + 1/2) / k) dx with k^3 = particles_per_cell, a = 0 .. k -
/// 1 per axis, those of a plane flow in the middle across it; a jittered one moves by at most 0.4 / k cells per axis. A body keeps the points with signed distance <= 0
/// that no earlier body holds; nothing is seeded outside the domain, and a body does not wrap around a periodic axis. id =
/// (body * number of cells + cell) * 64 + place in the cell, z fastest. Throws UsageError for a degenerate shape, a lattice
/// that is not 1, 8, 27 or 64, a density <= 0, or ids that overflow, and RunError if the particles exceed what one rank can
/// index; `particles` is then unchanged. Not collective.
void seed_particles(const GridGeometry& grid, const std::vector<Body>& bodies, const std::vector<TileIndex>& tiles,
                    ParticleSet& particles);

}  // namespace bulkley
