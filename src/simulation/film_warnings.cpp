#include "simulation/film_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "rheometer/film.hpp"

namespace bulkley {

namespace {

/// The axis that gravity is along, if it is along one.
std::optional<int> axis_of(const Vec3& gravity) {
  int axis = 0;
  const double size = gravity.cwiseAbs().maxCoeff(&axis);
  if (!(size > 0.0) || gravity.norm() > size * (1.0 + 1e-9)) return std::nullopt;
  return axis;
}

bool has_floor(const Scene& scene, int axis) {
  const std::size_t face = 2 * static_cast<std::size_t>(axis) + (scene.gravity[axis] < 0.0 ? 0 : 1);
  if (behaviour(scene.faces[face].kind).contact) return true;
  return std::ranges::any_of(scene.colliders, [&](const Collider& collider) {
    const auto* plane = std::get_if<Plane>(&collider.shape.kind);
    return plane && -plane->normal.normalized().dot(scene.gravity.normalized()) > 1.0 - 1e-9;
  });
}

bool may_hold(const Collider& collider) {
  const auto& kind = collider.shape.kind;
  return std::holds_alternative<Complement>(kind) || std::holds_alternative<Difference>(kind) ||
         std::holds_alternative<Union>(kind) || std::holds_alternative<Mesh>(kind) || std::holds_alternative<Placed>(kind);
}

}  // namespace

std::vector<std::string> film_warnings(const Scene& scene, const std::vector<BodyForecast>& bodies) {
  const std::optional<int> axis = axis_of(scene.gravity);
  if (!axis || !has_floor(scene, *axis) || std::ranges::any_of(scene.colliders, may_hold)) return {};
  const Vec3 size = scene.grid.upper() - scene.grid.lower;
  std::vector<std::string> warnings;
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    double mass = 0.0, density = 0.0, tallest = 0.0;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      if (scene.bodies[b].material_index != m) continue;
      const Bounds box = bounds(scene.bodies[b].shape);
      mass += bodies[b].mass;
      density = scene.bodies[b].density;
      tallest = std::max(tallest, box.upper[*axis] - box.lower[*axis]);
    }
    const auto stress = characteristic_stress(scene.materials[m].material, 0.0);
    if (!stress || !(stress->yield > 0.0) || !(mass > 0.0)) continue;
    const Film film{mass / density, stress->yield / (density * scene.gravity.norm()), size[(*axis + 1) % 3],
                    size[(*axis + 2) % 3]};
    const double cells = film.mean_height() / scene.grid.cell_size;
    if (cells >= fewest_film_cells || film.middle() >= tallest) continue;
    warnings.push_back(fmt::format(
        "'{}' comes to rest on the floor as a film about {:.2g} m thick or thinner, {:.2g} cells: fewer than {:g} "
        "do not resolve it; cells of {:.2g} m would",
        scene.materials[m].name, film.mean_height(), cells, fewest_film_cells, film.mean_height() / fewest_film_cells));
  }
  return warnings;
}

}  // namespace bulkley
