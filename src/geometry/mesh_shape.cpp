#include "geometry/mesh_shape.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"
#include "geometry/sampled_distance.hpp"

namespace bulkley {

namespace {

std::vector<Shape> with_meshes_in(const std::vector<Shape>& parts, const std::function<Mesh(const Mesh&)>& replacement) {
  std::vector<Shape> result;
  for (const Shape& part : parts) result.push_back(with_meshes(part, replacement));
  return result;
}

/// A quarter turn that brings the file's upward axis to z.
Vec3 turned_up(Axis up, const Vec3& v) {
  if (up == Axis::y) return {v[0], -v[2], v[1]};
  if (up == Axis::x) return {-v[2], v[1], v[0]};
  return v;
}

void place(const Mesh& mesh, TriangleMesh& triangles) {
  for (Vec3& v : triangles.vertices) v = turned_up(mesh.up, v);
  Vec3 lower = triangles.vertices.front(), upper = lower;
  for (const Vec3& v : triangles.vertices) {
    lower = lower.cwiseMin(v);
    upper = upper.cwiseMax(v);
  }
  const double scale = mesh.size ? *mesh.size / (upper - lower).maxCoeff() : mesh.scale;
  const Vec3 middle = 0.5 * (lower + upper);
  const Vec3 to = mesh.center ? *mesh.center : Vec3(scale * middle);
  for (Vec3& v : triangles.vertices) v = scale * (v - middle) + to;
}

constexpr std::size_t n_probes = 2000;   ///< triangles behind which an inside is searched
constexpr double clearly_inside = 0.55;  ///< a flat sheet has up to 1/2, and the error of the dipoles, just behind it

/// Whether some point close behind a triangle is inside.
bool encloses_something(const MeshSolid& solid) {
  const TriangleMesh& mesh = solid.mesh();
  const double size = (solid.facts().upper - solid.facts().lower).norm();
  const double sense = solid.facts().volume < 0.0 ? -1.0 : 1.0;
  const std::size_t stride = std::max<std::size_t>(1, mesh.triangles.size() / n_probes);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += stride) {
    const auto at = [&](std::size_t corner) -> const Vec3& {
      return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][corner])];
    };
    const Vec3 area = sense * (at(1) - at(0)).cross(at(2) - at(0));
    if (!(area.norm() > 0.0)) continue;
    const Vec3 middle = (at(0) + at(1) + at(2)) / 3.0;
    for (const double depth : {1e-4, 1e-3, 1e-2})
      if (solid.winding_number(middle - depth * size * area.normalized()) > clearly_inside) return true;
  }
  return false;
}

}  // namespace

void visit_meshes(const Shape& shape, const std::function<void(const Mesh&)>& visit) {
  const auto visit_all = [&](const std::vector<Shape>& parts) {
    for (const Shape& part : parts) visit_meshes(part, visit);
  };
  if (const auto* mesh = std::get_if<Mesh>(&shape.kind)) visit(*mesh);
  if (const auto* all = std::get_if<Union>(&shape.kind)) visit_all(all->parts);
  if (const auto* difference = std::get_if<Difference>(&shape.kind)) visit_all(difference->parts);
  if (const auto* complement = std::get_if<Complement>(&shape.kind)) visit_all(complement->inside.parts);
  if (const auto* placed = std::get_if<Placed>(&shape.kind)) visit_meshes(*placed->part, visit);
}

bool waits_for_mesh(const Shape& shape) {
  bool waits = false;
  visit_meshes(shape, [&](const Mesh& mesh) { waits = waits || !mesh.solid; });
  return waits;
}

Shape with_meshes(const Shape& shape, const std::function<Mesh(const Mesh&)>& replacement) {
  Shape result = shape;
  if (auto* mesh = std::get_if<Mesh>(&result.kind)) *mesh = replacement(*mesh);
  if (auto* all = std::get_if<Union>(&result.kind)) all->parts = with_meshes_in(all->parts, replacement);
  if (auto* difference = std::get_if<Difference>(&result.kind))
    difference->parts = with_meshes_in(difference->parts, replacement);
  if (auto* complement = std::get_if<Complement>(&result.kind))
    complement->inside.parts = with_meshes_in(complement->inside.parts, replacement);
  if (auto* placed = std::get_if<Placed>(&result.kind))
    placed->part = std::make_shared<const Shape>(with_meshes(*placed->part, replacement));
  return result;
}

WeldCount weld_checked(TriangleMesh& triangles) {
  if (triangles.triangles.empty()) throw UsageError("holds no triangle or polygon");
  const auto n_vertices = static_cast<int>(triangles.vertices.size());
  for (const Int3& t : triangles.triangles)
    for (const int v : t)
      if (v < 0 || v >= n_vertices)
        throw UsageError(fmt::format("has a face with vertex {}, but only {} vertices (the first is 0)", v, n_vertices));
  std::size_t n_unplaced = 0;
  for (const Vec3& v : triangles.vertices)
    if (!v.allFinite()) ++n_unplaced;
  if (n_unplaced > 0)
    throw UsageError(fmt::format("has {} of {} vertices with coordinates that are NaN or infinite", n_unplaced, n_vertices));
  constexpr double farthest = 1e30;  // the sixth power of a length must be a number
  for (const Vec3& v : triangles.vertices)
    if (v.cwiseAbs().maxCoeff() > farthest) throw UsageError(fmt::format("has a coordinate beyond {:g}", farthest));
  const std::size_t n_before = triangles.triangles.size();
  const WeldCount count = weld(triangles);
  if (triangles.triangles.empty() || !(facts(triangles).area > 0.0))
    throw UsageError(fmt::format("has {} triangles, none of which has an area", n_before));
  return count;
}

Mesh filled(const Mesh& mesh, TriangleMesh triangles) {
  place(mesh, triangles);
  constexpr double farthest = 1e30;  // m
  for (const Vec3& v : triangles.vertices)
    if (!(v.cwiseAbs().maxCoeff() <= farthest))
      throw UsageError(fmt::format("reaches farther than {:g} m from the origin", farthest));
  Mesh result = mesh;
  result.solid = std::make_shared<const MeshSolid>(std::move(triangles));
  if (!encloses_something(*result.solid))
    throw UsageError("encloses nothing: its triangles are a sheet, or do not all face the same way");
  return result;
}

Shape sampled_for_contact(const Shape& shape, double cell_size) {
  return with_meshes(shape, [&](const Mesh& mesh) {
    Mesh result = mesh;
    if (mesh.solid) result.sampled = std::make_shared<const SampledDistance>(mesh.solid, 0.5 * cell_size, 4.0 * cell_size);
    return result;
  });
}

}  // namespace bulkley
