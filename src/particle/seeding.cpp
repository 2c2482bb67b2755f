#include "particle/seeding.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/hash.hpp"
#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

constexpr GlobalIndex places_per_cell = 64;  ///< ids set aside for each cell and body: the largest lattice
constexpr double largest_jitter = 0.4;       ///< of the lattice spacing: neighbours never meet, and nothing leaves its cell

/// k of the k x k x k lattice in a cell, of which the cells of a plane flow have the layer in the middle.
int lattice_width(const Body& body) {
  for (int k = 1; k <= 4; ++k)
    if (k * k * k == body.particles_per_cell) return k;
  throw UsageError("body '" + body.name + "': particles_per_cell = " + std::to_string(body.particles_per_cell) +
                   " must be 1, 8, 27 or 64");
}

GlobalIndex n_cells_global(const GridGeometry& grid) {
  return static_cast<GlobalIndex>(grid.n_cells[0]) * grid.n_cells[1] * grid.n_cells[2];
}

GlobalIndex cell_index(const GridGeometry& grid, const Int3& cell) {
  return (static_cast<GlobalIndex>(cell[0]) * grid.n_cells[1] + cell[1]) * grid.n_cells[2] + cell[2];
}

void check_bodies(const GridGeometry& grid, const std::vector<Body>& bodies) {
  for (const Body& body : bodies) {
    check_shape(body.shape, "body '" + body.name + "'");
    lattice_width(body);
  }
  const GlobalIndex largest = std::numeric_limits<GlobalIndex>::max();
  if (static_cast<GlobalIndex>(bodies.size()) > largest / places_per_cell / n_cells_global(grid))
    throw UsageError("the grid has too many cells for 64-bit particle ids: " + std::to_string(bodies.size()) + " bodies x " +
                     std::to_string(n_cells_global(grid)) + " cells x " + std::to_string(places_per_cell) +
                     " must stay below 2^63");
}

/// Uniform in [-1, 1), from a hash of its arguments.
double random_offset(std::uint64_t seed, GlobalIndex cell, int place, int axis) {
  const std::uint64_t bits = splitmix64(splitmix64(splitmix64(seed) ^ static_cast<std::uint64_t>(cell)) ^
                                        static_cast<std::uint64_t>(4 * place + axis));
  return static_cast<double>(bits >> 11) * 0x1p-52 - 1.0;
}

/// A box of cells, first <= cell < last along each axis.
struct CellBox {
  Int3 first, last;
};

struct CellRange {
  int first, last;
};

/// The cells along one axis that hold points of the tiles with this coordinate: one range, or two where the axis wraps.
std::vector<CellRange> cells_of_tile(const GridGeometry& grid, int axis, int tile) {
  const int n = grid.n_cells[static_cast<std::size_t>(axis)];
  const double start = tile_width * tile - grid.node_offset(axis) + grid.base_shift();
  const int first = static_cast<int>(std::floor(start));
  const int last = static_cast<int>(std::ceil(start + tile_width));
  if (!grid.periodic[static_cast<std::size_t>(axis)]) {
    const CellRange inside{std::max(first, 0), std::min(last, n)};
    return inside.first < inside.last ? std::vector{inside} : std::vector<CellRange>{};
  }
  if (last - first >= n) return {{0, n}};
  std::vector<CellRange> result;
  if (first < n) result.push_back({first, std::min(last, n)});
  if (last > n) result.push_back({std::max(first - n, 0), last - n});
  return result;
}

std::vector<CellBox> cell_boxes(const GridGeometry& grid, TileIndex tile) {
  const Int3 t = grid.tile_coordinates(tile);
  std::vector<CellBox> result;
  for (const CellRange& x : cells_of_tile(grid, 0, t[0]))
    for (const CellRange& y : cells_of_tile(grid, 1, t[1]))
      for (const CellRange& z : cells_of_tile(grid, 2, t[2]))
        result.push_back({{x.first, y.first, z.first}, {x.last, y.last, z.last}});
  return result;
}

/// A body that reaches into a box of cells.
struct BodyNear {
  std::size_t index;
  bool everywhere;  ///< it fills the box
};

/// Tiles with first <= coordinate <= last along each axis.
struct TileSpan {
  Int3 first, last;
};

/// The tiles that may hold particles of the bodies.
TileSpan tiles_near(const GridGeometry& grid, const std::vector<Body>& bodies) {
  Bounds all{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
  for (const Body& body : bodies) {
    const Bounds b = bounds(body.shape);
    all.lower = all.lower.cwiseMin(b.lower);
    all.upper = all.upper.cwiseMax(b.upper);
  }
  TileSpan result;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    result.first[a] = 0;
    result.last[a] = grid.n_tiles(axis) - 1;
    if (grid.periodic[a]) continue;  // the first tile may hold points of the upper end
    // One cell more on both sides, for rounding; and within the grid before it becomes an integer.
    const auto tile_at = [&](double coordinate, double margin) {
      const double node = (coordinate - grid.lower[axis]) / grid.cell_size + margin - grid.base_shift() + 1.0;
      return static_cast<int>(std::min(std::max(0.0, node), grid.n_nodes(axis) - 1.0)) / tile_width;
    };
    result.first[a] = tile_at(all.lower[axis], -1.0);
    result.last[a] = tile_at(all.upper[axis], 1.0);
  }
  return result;
}

/// Calls visit(tile) for those of the tiles with first <= index < last that may hold particles, in their order.
template <class Visit>
void for_each_tile_near(const GridGeometry& grid, const std::vector<Body>& bodies, TileIndex first, TileIndex last,
                        const Visit& visit) {
  const TileSpan box = tiles_near(grid, bodies);
  const Int3 from = grid.tile_coordinates(std::min(first, grid.n_tiles() - 1));
  for (int i = std::max(box.first[0], from[0]); i <= box.last[0]; ++i)
    for (int j = box.first[1]; j <= box.last[1]; ++j) {
      if (grid.tile_index({i, j, 0}) >= last) return;
      for (int k = box.first[2]; k <= box.last[2]; ++k) {
        const TileIndex tile = grid.tile_index({i, j, k});
        if (tile >= first && tile < last) visit(tile);
      }
    }
}

/// The bodies that may hold points of the box, in their order; none after one that fills it.
std::vector<BodyNear> bodies_near(const GridGeometry& grid, const std::vector<Body>& bodies, const CellBox& box) {
  const Vec3 first(box.first[0], box.first[1], box.first[2]);
  const Vec3 last(box.last[0], box.last[1], box.last[2]);
  const Vec3 center = grid.lower + 0.5 * (first + last) * grid.cell_size;
  const double half_diagonal = 0.5 * (last - first).norm() * grid.cell_size;
  std::vector<BodyNear> result;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const double distance = signed_distance_within(bodies[b].shape, center, 1.01 * half_diagonal);
    if (distance > half_diagonal) continue;
    result.push_back({b, distance < -half_diagonal});
    if (result.back().everywhere) break;
  }
  return result;
}

/// Whether the point belongs to near[n]: inside it, and in no body before it.
bool belongs(const std::vector<Body>& bodies, const std::vector<BodyNear>& near, std::size_t n, const Vec3& position) {
  for (std::size_t earlier = 0; earlier < n; ++earlier)
    if (contains(bodies[near[earlier].index].shape, position)) return false;
  return near[n].everywhere || contains(bodies[near[n].index].shape, position);
}

/// Calls visit(position, place) for each lattice point of `body` in `cell`.
template <class Visit>
void visit_lattice(const GridGeometry& grid, const Body& body, const Int3& cell, const Visit& visit) {
  const int k = lattice_width(body);
  const double spacing = 1.0 / k;
  for (int place = 0; place < k * k * k; ++place) {
    const Int3 a{place / (k * k), (place / k) % k, place % k};
    Vec3 position;
    bool is_copy = false;  // of a particle that is before it across a plane flow
    for (int axis = 0; axis < 3; ++axis) {
      const auto c = static_cast<std::size_t>(axis);
      const bool across = grid.is_plane(axis);
      is_copy = is_copy || (across && a[c] > 0);
      double in_cell = across ? 0.5 : (a[c] + 0.5) * spacing;
      if (body.lattice == SeedingLattice::jittered && !across)
        in_cell += largest_jitter * spacing * random_offset(body.seed, cell_index(grid, cell), place, axis);
      position[axis] = grid.lower[axis] + (cell[c] + in_cell) * grid.cell_size;
    }
    if (!is_copy) visit(position, place);
  }
}

/// Calls visit(body, position, id) for each particle of `tile`.
template <class Visit>
void visit_tile(const GridGeometry& grid, const std::vector<Body>& bodies, TileIndex tile, const Visit& visit) {
  for (const CellBox& box : cell_boxes(grid, tile)) {
    const std::vector<BodyNear> near = bodies_near(grid, bodies, box);
    for (std::size_t n = 0; n < near.size(); ++n) {
      const std::size_t b = near[n].index;
      for (int i = box.first[0]; i < box.last[0]; ++i)
        for (int j = box.first[1]; j < box.last[1]; ++j)
          for (int k = box.first[2]; k < box.last[2]; ++k) {
            const Int3 cell{i, j, k};
            const GlobalIndex first_id =
                (static_cast<GlobalIndex>(b) * n_cells_global(grid) + cell_index(grid, cell)) * places_per_cell;
            visit_lattice(grid, bodies[b], cell, [&](const Vec3& position, int place) {
              if (grid.tile_of(position) == tile && belongs(bodies, near, n, position)) visit(b, position, first_id + place);
            });
          }
    }
  }
}

/// A particle that is yet to be stored.
struct Seed {
  Vec3 position;
  GlobalIndex id;
  std::size_t body;
};

void store(const GridGeometry& grid, const Body& body, const Seed& seed, StartMotion& motion, LocalIndex p,
           ParticleSet& particles) {
  const double volume = grid.cell_size * grid.cell_size * grid.cell_size / particles_in_cell(grid, body);
  particles.set_vector(Field::position, p, seed.position);
  particles.set_vector(Field::velocity, p, motion.velocity(seed.position));
  const Mat3 gradient = motion.gradient(seed.position);
  for (int c = 0; c < 9; ++c) particles.real(Field::affine_velocity, c)[p] = gradient(c / 3, c % 3);
  for (int c = 0; c < 3; ++c) particles.real(Field::left_cauchy_green, c)[p] = 1.0;
  particles.real(Field::volume_ratio)[p] = 1.0;
  particles.real(Field::reference_volume)[p] = volume;
  particles.material()[p] = body.material_index;
  particles.id()[p] = seed.id;
}

// Of a cell: the differences of a wave of six cells are wrong by 6e-10 of its gradient, and rounding stays below that for
// any usual distance from the origin.
constexpr double difference_step = 0x1p-14;

}  // namespace

int particles_in_cell(const GridGeometry& grid, const Body& body) {
  const int k = lattice_width(body);
  return (grid.is_plane(0) ? 1 : k) * (grid.is_plane(1) ? 1 : k) * (grid.is_plane(2) ? 1 : k);
}

StartMotion::StartMotion(const GridGeometry& grid, const Body& body)
    : velocity_(body.velocity),
      angular_velocity_(body.angular_velocity),
      center_(body.center ? *body.center : bounds(body.shape).center()),
      step_(difference_step * grid.cell_size) {
  if (body.velocity_field.given()) field_.emplace(body.velocity_field);
}

Vec3 StartMotion::velocity(const Vec3& position) {
  const Vec3 rigid = velocity_ + angular_velocity_.cross(position - center_);
  return field_ ? Vec3(rigid + (*field_)(position, 0.0)) : rigid;
}

Mat3 StartMotion::gradient(const Vec3& position) {
  const Vec3& omega = angular_velocity_;
  Mat3 spin;
  spin << 0.0, -omega[2], omega[1], omega[2], 0.0, -omega[0], -omega[1], omega[0], 0.0;
  return field_ ? Mat3(spin + field_->gradient(position, 0.0, step_)) : spin;
}

std::optional<UndefinedMotion> find_undefined_motion(const GridGeometry& grid, const std::vector<Body>& bodies,
                                                     TileIndex first, TileIndex last) {
  std::optional<UndefinedMotion> found;
  std::vector<StartMotion> motions;
  bool any_field = false;
  for (const Body& body : bodies) {
    motions.emplace_back(grid, body);
    any_field = any_field || body.velocity_field.given();
  }
  if (!any_field) return found;
  for_each_tile_near(grid, bodies, first, last, [&](TileIndex tile) {
    if (found) return;
    visit_tile(grid, bodies, tile, [&](std::size_t b, const Vec3& position, GlobalIndex) {
      if (found || !bodies[b].velocity_field.given()) return;
      if (!motions[b].velocity(position).allFinite() || !motions[b].gradient(position).allFinite())
        found = UndefinedMotion{b, position};
    });
  });
  return found;
}

TileCensus count_particles(const GridGeometry& grid, const std::vector<Body>& bodies, TileIndex first, TileIndex last) {
  check_bodies(grid, bodies);
  TileCensus census;
  for (const Body& body : bodies) census.n_materials = std::max(census.n_materials, body.material_index + 1);
  for_each_tile_near(grid, bodies, first, last, [&](TileIndex tile) {
    visit_tile(grid, bodies, tile, [&](std::size_t body, const Vec3& position, GlobalIndex) {
      if (census.tile.empty() || census.tile.back() != tile) {
        census.tile.push_back(tile);
        census.count.resize(census.count.size() + static_cast<std::size_t>(census.n_materials), 0);
        census.cells.push_back(0);
      }
      ++census.count[census.count.size() - static_cast<std::size_t>(census.n_materials - bodies[body].material_index)];
      census.cells.back() |= std::uint64_t{1} << grid.place_in_tile(position);
    });
  });
  return census;
}

void seed_particles(const GridGeometry& grid, const std::vector<Body>& bodies, const std::vector<TileIndex>& tiles,
                    ParticleSet& particles) {
  check_bodies(grid, bodies);
  for (const Body& body : bodies)
    if (!(body.density > 0.0 && std::isfinite(body.density)))
      throw UsageError("body '" + body.name + "': density = " + std::to_string(body.density) +
                       " must be a finite number > 0");

  const LocalIndex before = particles.size();
  std::vector<StartMotion> motions;
  for (const Body& body : bodies) motions.emplace_back(grid, body);
  std::vector<Seed> seeds;  // of a tile
  for (const TileIndex tile : tiles) {
    seeds.clear();
    visit_tile(grid, bodies, tile, [&](std::size_t body, const Vec3& position, GlobalIndex id) {
      seeds.push_back({position, id, body});
    });
    LocalIndex p = particles.size();
    try {
      particles.resize(ParticleSet::checked_size(p + static_cast<GlobalIndex>(seeds.size())));
    } catch (const RunError&) {
      particles.resize(before);
      throw;
    }
    for (const Seed& seed : seeds) store(grid, bodies[seed.body], seed, motions[seed.body], p++, particles);
  }
}

}  // namespace bulkley
