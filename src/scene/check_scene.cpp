#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_shape.hpp"
#include "geometry/thickness.hpp"
#include "scene/scene.hpp"

namespace bulkley {

BodySurvey survey_alone() {
  return {[](const GridGeometry& grid, const std::vector<Body>& bodies) {
            return count_particles(grid, bodies, 0, grid.n_tiles()).n_particles();
          },
          [](const GridGeometry& grid, const std::vector<Body>& bodies) {
            return find_undefined_motion(grid, bodies, 0, grid.n_tiles());
          }};
}

namespace {

/// Whether bounds() is the smallest box, not just one that holds the shape.
bool has_exact_bounds(const Shape& shape) {
  if (const auto* placed = std::get_if<Placed>(&shape.kind)) return placed->angle == 0.0 && has_exact_bounds(*placed->part);
  if (std::holds_alternative<Difference>(shape.kind)) return false;
  if (const auto* all = std::get_if<Union>(&shape.kind)) {
    for (const Shape& part : all->parts)
      if (!has_exact_bounds(part)) return false;
  }
  return true;
}

bool holds(const GridGeometry& grid, const Bounds& b) {
  const double rounding = 1e-9 * grid.cell_size;
  return ((b.lower - grid.lower).array() >= -rounding).all() && ((grid.upper() - b.upper).array() >= -rounding).all();
}

/// The grid, grown by whole cells until it holds the bounds, without periodic axes; none if counting in it would take
/// forever.
std::optional<GridGeometry> enlarged(const GridGeometry& grid, const Bounds& b) {
  constexpr double most_cells = 1 << 24;  // per axis
  constexpr double most_tiles = 1 << 22;  // counted in a second
  constexpr double most_tiles_of_ours =
      8.0;  // times those of the grid: the bounds of a turned body may have 3^(3/2) its volume
  GridGeometry result = grid;
  double n_tiles = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double below = std::max(0.0, std::ceil((grid.lower[axis] - b.lower[axis]) / grid.cell_size));
    const double above = std::max(0.0, std::ceil((b.upper[axis] - grid.upper()[axis]) / grid.cell_size));
    if (!(below + above <= most_cells)) return std::nullopt;
    result.lower[axis] -= below * grid.cell_size;
    result.n_cells[a] += static_cast<int>(below + above);
    result.periodic[a] = false;
    n_tiles *= result.n_tiles(axis);
  }
  const double allowed = std::max(most_tiles, most_tiles_of_ours * grid.n_tiles());
  if (n_tiles > std::min(allowed, 1.0 * std::numeric_limits<TileIndex>::max())) return std::nullopt;
  return result;
}

/// Judged by the bounds where they are exact, else by the lattice points that lie outside.
bool reaches_outside(const GridGeometry& grid, const Body& body, const BodySurvey& survey) {
  const Bounds b = bounds(body.shape);
  if (holds(grid, b)) return false;
  if (has_exact_bounds(body.shape)) return true;
  Body regular = body;
  regular.lattice = SeedingLattice::regular;  // random shifts would differ between the two grids
  const std::optional<GridGeometry> whole = enlarged(grid, b);
  return !whole || survey.count(*whole, {regular}) != survey.count(grid, {regular});
}

bool overlap(const Bounds& x, const Bounds& y) {
  return (x.lower.array() <= y.upper.array()).all() && (y.lower.array() <= x.upper.array()).all();
}

std::string vector_text(const Vec3& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0], v[1], v[2]); }

/// What a user should know of the meshes of a body that is too large or too small.
std::string units_hint(const Shape& shape) {
  std::string hint;
  visit_meshes(shape, [&](const Mesh& mesh) {
    const double size = (mesh.solid->facts().upper - mesh.solid->facts().lower).maxCoeff();
    hint += fmt::format(
        "; its mesh is {:.4g} m large: if that is unintended, give 'size', or the file's unit as 'scale' (0.001 "
        "for millimetres)",
        size);
  });
  return hint;
}

constexpr double too_many_particles = 1e11;

/// How many particles fill the meshes of a body, roughly.
double particles_in_meshes(const GridGeometry& grid, const Body& body) {
  double volume = 0.0;
  visit_meshes(body.shape, [&](const Mesh& mesh) { volume += std::abs(mesh.solid->facts().volume); });
  return volume / std::pow(grid.cell_size, 3) * particles_in_cell(grid, body);
}

/// How many particles a body has within the domain, from a coarse lattice; 0 where they cannot be too many.
double particles_in_shape(const GridGeometry& grid, const Body& body) {
  const Bounds b = bounds(body.shape);
  const Vec3 lower = b.lower.cwiseMax(grid.lower), size = b.upper.cwiseMin(grid.upper()) - lower;
  if (!(size.minCoeff() > 0.0)) return 0.0;
  const double most = (size / grid.cell_size).prod() * particles_in_cell(grid, body);
  if (most <= too_many_particles) return 0.0;
  constexpr int n = 24;  // points along each axis
  int inside = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        inside += contains(body.shape, lower + (Vec3(i, j, k).array() + 0.5).matrix().cwiseProduct(size) / n) ? 1 : 0;
  return most * inside / (n * n * n);
}

/// Whether a shape with a mesh is so large that it cannot lie in the domain however it is turned: counting its particles to
/// find out could take forever.
bool far_too_large(const GridGeometry& grid, const Shape& shape) {
  bool has_mesh = false;
  visit_meshes(shape, [&](const Mesh&) { has_mesh = true; });
  if (!has_mesh || std::holds_alternative<Difference>(shape.kind)) return false;
  const Bounds b = bounds(shape);
  // The bounds of what is turned may be too large by sqrt(3).
  return (b.upper - b.lower).maxCoeff() > std::sqrt(3.0) * (grid.upper() - grid.lower).norm();
}

}  // namespace

void check_bodies(const Scene& scene, const BodySurvey& survey) {
  std::string faults;
  const auto refuse = [&](std::size_t b, const std::string& sentence) {
    const std::string place = b < scene.body_places.size() ? scene.body_places[b] + ": " : "";
    faults += fmt::format("{}{}body '{}' {}", faults.empty() ? "" : "\n", place, scene.bodies[b].name, sentence);
  };
  const GridGeometry& grid = scene.grid;
  std::vector<GlobalIndex> counts;  // of each body alone
  std::vector<Bounds> boxes;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const Bounds box = bounds(body.shape);
    counts.push_back(0);
    boxes.push_back(box);
    if (!box.lower.allFinite() || !box.upper.allFinite()) {
      refuse(b, "contains a plane or complement, which is for colliders only");
    } else if (const double n = std::max(particles_in_meshes(grid, body), particles_in_shape(grid, body));
               n > too_many_particles) {
      refuse(b, fmt::format("would be filled with some {:.1g} particles{}", n, units_hint(body.shape)));
    } else if (far_too_large(grid, body.shape) || reaches_outside(grid, body, survey)) {
      refuse(b, fmt::format("reaches from {} to {}, outside the domain from {} to {}{}", vector_text(box.lower),
                            vector_text(box.upper), vector_text(grid.lower), vector_text(grid.upper()),
                            units_hint(body.shape)));
    } else {
      counts[b] = survey.count(grid, {body});
      if (counts[b] == 0)
        refuse(b, fmt::format(
                      "is too small to hold a particle; make it larger, the cells of {} m smaller, or particles_per_cell "
                      "greater than {}{}",
                      grid.cell_size, body.particles_per_cell, units_hint(body.shape)));
    }
  }
  if (!scene.inflows.empty()) check_inflows(scene);
  if (const auto undefined = survey.find_undefined_motion(grid, scene.bodies))
    refuse(undefined->body,
           fmt::format("has a velocity_field without a finite value or gradient at {} m: {}",
                       vector_text(undefined->position), scene.bodies[undefined->body].velocity_field.words()));
  for (std::size_t b = 1; b < scene.bodies.size() && !scene.allow_overlap; ++b)
    for (std::size_t a = 0; a < b; ++a) {
      const Body &first = scene.bodies[a], &second = scene.bodies[b];
      if (counts[a] == 0 || counts[b] == 0 || !overlap(boxes[a], boxes[b])) continue;
      // The later body of a list loses the points that lie in the earlier one: try both orders.
      const GlobalIndex lost_by_second = counts[a] + counts[b] - survey.count(grid, {first, second});
      const GlobalIndex lost =
          lost_by_second > 0 ? lost_by_second : counts[a] + counts[b] - survey.count(grid, {second, first});
      if (lost > 0)
        refuse(b, fmt::format(
                      "overlaps body '{}' in {} particles; move one of them, or set allow_overlap = true to let the first "
                      "body win",
                      first.name, lost));
    }
  if (!faults.empty()) throw UsageError(faults);
}

void check_colliders(const Scene& scene) {
  const GridGeometry& grid = scene.grid;
  // What the sampling of the surface resolves, so that an obstacle of just two cells passes.
  const double needed = 2.0 * grid.cell_size, tolerance = 0.03 * needed;
  std::string faults;
  for (std::size_t c = 0; c < scene.colliders.size(); ++c) {
    const Collider& collider = scene.colliders[c];
    const Bounds whole = bounds(collider.shape);
    const bool is_finite = whole.lower.allFinite() && whole.upper.allFinite();
    const Bounds window = is_finite ? whole : Bounds{grid.lower, grid.upper()};
    const double found = thickness(collider.shape, window, needed);
    if (found >= needed - tolerance) continue;
    const std::string place = c < scene.collider_places.size() ? scene.collider_places[c] + ": " : "";
    faults += fmt::format(
        "{}{}collider '{}' is {:.3g} m thick, {:.2g} cells: it must be at least 2 cells thick, or material on one side "
        "interacts with material on the other; make it {:.3g} m thick or the cells at most {:.3g} m",
        faults.empty() ? "" : "\n", place, collider.name, found, found / grid.cell_size, needed, 0.5 * found);
  }
  if (!faults.empty()) throw UsageError(faults);
}

}  // namespace bulkley
