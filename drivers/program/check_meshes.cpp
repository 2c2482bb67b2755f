#include "program/check_meshes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "geometry/mesh_shape.hpp"
#include "program/human_text.hpp"

namespace bulkley {

namespace {

/// The mesh that the shape is and nothing else, placed or not; null if it is more.
const Mesh* sole_mesh(const Shape& shape) {
  if (const auto* placed = std::get_if<Placed>(&shape.kind)) return sole_mesh(*placed->part);
  return std::get_if<Mesh>(&shape.kind);
}

/// `seeded`: m^3, NaN where particles of this mesh cannot be distinguished from others.
void print_mesh(const std::string& owner, const Mesh& mesh, double seeded) {
  const MeshFacts& facts = mesh.solid->facts();
  const Vec3 size = facts.upper - facts.lower;
  fmt::print("mesh       {}: {}\n", owner, mesh.file);
  fmt::print("           {} triangles, {}, {}; {:.4g} x {:.4g} x {:.4g} m\n", mesh.solid->mesh().triangles.size(),
             facts.closed() ? "closed" : counted(static_cast<double>(facts.n_holes), "hole"),
             counted(static_cast<double>(facts.n_components), "component"), size[0], size[1], size[2]);
  const double volume = std::abs(facts.volume);
  fmt::print("           volume {:.6g} m^3 by the divergence theorem", volume);
  if (std::isfinite(seeded)) fmt::print(", seeded {:.6g} m^3, ratio {:.4f}", seeded, seeded / volume);
  fmt::print("\n");
}

void warn_of(const Mesh& mesh) {
  const MeshFacts& facts = mesh.solid->facts();
  const auto warn = [&](const std::string& sentence) { fmt::print("warning: mesh '{}' {}\n", mesh.file, sentence); };
  if (!facts.closed())
    warn(fmt::format(
        "is not closed: {} with {} at their rims; the surface of winding number 1/2 closes them, and the volume is "
        "only about right",
        counted(static_cast<double>(facts.n_holes), "hole"),
        counted(static_cast<double>(facts.n_boundary_edges), "boundary edge")));
  if (facts.volume < 0.0) warn("faces inwards: it is taken the other way round");
  const WeldCount& dropped = mesh.welded;
  if (dropped.degenerate > 0)
    warn(fmt::format("has {} without area, dropped", counted(static_cast<double>(dropped.degenerate), "triangle")));
  if (dropped.duplicates > 0)
    warn(fmt::format("has {}, dropped", counted(static_cast<double>(dropped.duplicates), "repeated triangle")));
  if (facts.n_components > 1)
    warn(fmt::format("has {} components; where they overlap they are one solid", facts.n_components));
}

}  // namespace

void print_meshes(const Scene& scene, const Forecast& forecast) {
  std::set<std::string> warned;
  const auto tell = [&](const std::string& owner, const Shape& shape, double seeded) {
    visit_meshes(shape, [&](const Mesh& mesh) {
      if (warned.empty()) fmt::print("\n");
      print_mesh(owner, mesh, &mesh == sole_mesh(shape) ? seeded : std::nan(""));
      if (warned.insert(mesh.file).second) warn_of(mesh);
    });
  };
  const double cell = std::pow(scene.grid.cell_size, 3);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    tell(fmt::format("body '{}'", body.name), body.shape,
         static_cast<double>(forecast.bodies[b].n_particles) * cell / body.particles_per_cell);
  }
  for (const Collider& collider : scene.colliders)
    tell(fmt::format("collider '{}'", collider.name), collider.shape, std::nan(""));
}

}  // namespace bulkley
