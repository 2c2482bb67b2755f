#include <fmt/format.h>

#include <cmath>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_shape.hpp"
#include "geometry/thickness.hpp"
#include "scene/scene.hpp"

namespace bulkley {

namespace {

/// The first of the bodies of material that fills more than the outer half cell of a rigid body, on a lattice of half a cell.
const Body* material_inside(const Scene& scene, const Shape& shape) {
  const Bounds box = bounds(shape);
  const double spacing = 0.5 * scene.grid.cell_size;
  const auto count = [&](int axis) {
    return static_cast<int>(std::ceil((box.upper[axis] - box.lower[axis]) / spacing)) + 1;
  };
  const Shape sampled = sampled_for_contact(shape, scene.grid.cell_size);
  for (int i = 0; i < count(0); ++i)
    for (int j = 0; j < count(1); ++j)
      for (int k = 0; k < count(2); ++k) {
        const Vec3 x = box.lower + spacing * Vec3(i, j, k);
        if (signed_distance(sampled, x) > -spacing) continue;
        for (const Body& body : scene.bodies)
          if (contains(body.shape, x)) return &body;
      }
  return nullptr;
}

std::string fault_of_one(const Scene& scene, const RigidBody& body) {
  const GridGeometry& grid = scene.grid;
  const Bounds box = bounds(body.shape);
  if (!box.lower.allFinite() || !box.upper.allFinite()) return "contains a plane or complement, which is for colliders only";
  if (const auto fault = mass_fault(body)) return *fault;
  const double needed = 2.0 * grid.cell_size, found = thickness(body.shape, box, needed);
  if (found < 0.97 * needed)  // what the sampling of the surface resolves
    return fmt::format("is {:.3g} m thick, {:.2g} cells; it must be at least 2 cells thick, or material passes through it",
                       found, found / grid.cell_size);
  for (int a = 0; a < 3; ++a) {
    const double period = grid.upper()[a] - grid.lower[a];
    if (grid.periodic[static_cast<std::size_t>(a)] && box.upper[a] - box.lower[a] > period - needed)
      return fmt::format(
          "is {:.3g} m long along a periodic axis of {:.3g} m; two cells must remain between it and its image",
          box.upper[a] - box.lower[a], period);
  }
  if (const Body* const filled = material_inside(scene, body.shape))
    return fmt::format(
        "holds material of body '{}' deeper than half a cell; take it out of that body, as a difference of shapes",
        filled->name);
  return {};
}

}  // namespace

void check_rigid_bodies(const Scene& scene) {
  std::string faults;
  const auto refuse = [&](std::size_t b, const std::string& sentence) {
    const std::string place = b < scene.rigid_places.size() ? scene.rigid_places[b] + ": " : "";
    faults += fmt::format("{}{}rigid body '{}' {}", faults.empty() ? "" : "\n", place, scene.rigid_bodies[b].name, sentence);
  };
  for (std::size_t b = 0; b < scene.rigid_bodies.size(); ++b)
    if (const std::string fault = fault_of_one(scene, scene.rigid_bodies[b]); !fault.empty()) refuse(b, fault);
  if (!faults.empty()) throw UsageError(faults);
  std::vector<RigidStart> starts;
  std::vector<RigidState> states;
  for (const RigidBody& body : scene.rigid_bodies) {
    starts.push_back(start_of(body, scene.grid.cell_size));
    states.push_back(starts.back().state);
  }
  for (std::size_t b = 0; b < scene.rigid_bodies.size(); ++b)
    if (const auto obstacle =
            obstacle_of(scene.grid, scene.colliders, scene.rigid_bodies, starts, states, b, 0.0, 0.5 * scene.grid.cell_size))
      refuse(b, fmt::format("reaches into {} by more than half a cell", *obstacle));
  if (!faults.empty()) throw UsageError(faults);
}

}  // namespace bulkley
