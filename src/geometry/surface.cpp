#include "geometry/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/isosurface.hpp"
#include "geometry/mesh_solid.hpp"

namespace bulkley {

namespace {

constexpr int n_segments = 48;        // to a full turn
constexpr double lattice_cells = 64;  // along the longest side of a traced shape

void append(TriangleMesh& mesh, const TriangleMesh& part) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const Int3& t : part.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

// --- bodies of revolution ----------------------------------------------------------------------------------------------

/// A point of the line that turns about the axis, m; counter-clockwise with the solid on the left of (radius, height).
struct ProfilePoint {
  double radius, height;
};

/// From `first` up to `last`, degrees from the equator.
void add_arc(std::vector<ProfilePoint>& profile, double radius, double height, double first, double last) {
  const int n = static_cast<int>(std::lround((last - first) / 360.0 * n_segments));
  for (int i = 0; i <= n; ++i) {
    const double angle = (first + (last - first) * i / n) * std::numbers::pi / 180.0;
    // The poles themselves must be on the axis.
    profile.push_back({std::abs(angle) > 0.4999999 * std::numbers::pi ? 0.0 : radius * std::cos(angle),
                       height + radius * std::sin(angle)});
  }
}

/// `profile` begins and ends on the axis, and touches it nowhere else.
TriangleMesh revolve(const Vec3& origin, const Vec3& axis, const std::vector<ProfilePoint>& profile) {
  const Vec3 side = axis.unitOrthogonal(), other = axis.cross(side);
  TriangleMesh mesh;
  const auto ring = [&](std::size_t row, int segment) {
    return row == 0 ? 0 : row + 1 == profile.size() ? 1 : 2 + static_cast<int>(row - 1) * n_segments + segment % n_segments;
  };
  for (const ProfilePoint& pole : {profile.front(), profile.back()}) mesh.vertices.push_back(origin + pole.height * axis);
  for (std::size_t row = 1; row + 1 < profile.size(); ++row)
    for (int s = 0; s < n_segments; ++s) {
      const double angle = 2.0 * std::numbers::pi * s / n_segments;
      mesh.vertices.push_back(origin + profile[row].height * axis +
                              profile[row].radius * (std::cos(angle) * side + std::sin(angle) * other));
    }
  for (std::size_t row = 0; row + 1 < profile.size(); ++row)
    for (int s = 0; s < n_segments; ++s) {
      const Int3 lower{ring(row, s), ring(row, s + 1), ring(row + 1, s + 1)};
      const Int3 upper{ring(row, s), ring(row + 1, s + 1), ring(row + 1, s)};
      if (row > 0) mesh.triangles.push_back(lower);
      if (row + 2 < profile.size()) mesh.triangles.push_back(upper);
    }
  return mesh;
}

TriangleMesh unit_ball() {
  std::vector<ProfilePoint> profile;
  add_arc(profile, 1.0, 0.0, -90.0, 90.0);
  return revolve(Vec3::Zero(), Vec3::UnitZ(), profile);
}

// --- one shape after another -------------------------------------------------------------------------------------------

bool is_bounded(const Shape& shape) {
  const Bounds b = bounds(shape);
  return b.lower.allFinite() && b.upper.allFinite();
}

/// A little wider, so that the faces of the box cut nothing off.
Bounds padded(const Bounds& b) {
  const Vec3 margin = Vec3::Constant(2.0 / lattice_cells * (b.upper - b.lower).maxCoeff());
  return {b.lower - margin, b.upper + margin};
}

/// `shape` must lie within `extent`. Vertices are moved onto the surface.
TriangleMesh traced(const Shape& shape, const Bounds& extent) {
  const Bounds reach = padded(extent);
  const double spacing = (reach.upper - reach.lower).maxCoeff() / lattice_cells;
  TriangleMesh mesh =
      isosurface([&](const Vec3& x) { return signed_distance(shape, x); }, reach.lower, reach.upper, spacing);
  for (Vec3& x : mesh.vertices)
    for (int pass = 0; pass < 2; ++pass) {
      const double distance = signed_distance(shape, x);
      // Where the distance is a bound only, or at an edge, a normal may lead astray.
      if (std::abs(distance) < spacing) x -= distance * outward_normal(shape, x);
    }
  return mesh;
}

/// The part of a shape without bounds that lies in the window.
TriangleMesh traced_in_window(const Shape& shape, const Bounds& window) {
  const Shape outside{Complement{Union{{Shape{Box{window.lower, window.upper}}}}}};
  return traced(Shape{Difference{{shape, outside}}}, window);
}

// --- half-spaces -------------------------------------------------------------------------------------------------------

/// Where the polygon lies behind the plane; corners that are new are also added to `cut`.
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, const Plane& plane, std::vector<Vec3>& cut) {
  const Shape half_space{plane};
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double at_a = signed_distance(half_space, a), at_b = signed_distance(half_space, b);
    if (at_a <= 0.0) kept.push_back(a);
    if ((at_a <= 0.0) == (at_b <= 0.0)) continue;
    // From the inner end, so that both faces at an edge find the very same point.
    const double inner = std::min(at_a, at_b), outer = std::max(at_a, at_b);
    const Vec3 &from = at_a <= 0.0 ? a : b, &to = at_a <= 0.0 ? b : a;
    kept.push_back(from + inner / (inner - outer) * (to - from));
    cut.push_back(kept.back());
  }
  return kept;
}

/// Puts the corners of a convex polygon in order around `normal`, counter-clockwise seen against it.
void order_around(std::vector<Vec3>& corners, const Vec3& normal) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : corners) middle += x / static_cast<double>(corners.size());
  const Vec3 side = normal.unitOrthogonal(), other = normal.cross(side);
  const auto angle = [&](const Vec3& x) { return std::atan2((x - middle).dot(other), (x - middle).dot(side)); };
  std::sort(corners.begin(), corners.end(), [&](const Vec3& a, const Vec3& b) { return angle(a) < angle(b); });
}

void append_fan(TriangleMesh& mesh, const std::vector<Vec3>& polygon) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), polygon.begin(), polygon.end());
  for (int i = 1; i + 1 < static_cast<int>(polygon.size()); ++i) mesh.triangles.push_back({first, first + i, first + i + 1});
}

// Corners of a box, counter-clockwise from outside; bit a of a corner: at the upper end of axis a.
constexpr std::array<std::array<int, 4>, 6> box_faces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

Vec3 corner_of(const Vec3& lower, const Vec3& upper, int corner) {
  return {(corner & 1 ? upper : lower).x(), (corner & 2 ? upper : lower).y(), (corner & 4 ? upper : lower).z()};
}

TriangleMesh surface(const Box& box, const Bounds&) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) mesh.vertices.push_back(corner_of(box.lower, box.upper, corner));
  for (const auto& f : box_faces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

TriangleMesh surface(const Ellipsoid& ellipsoid, const Bounds&) {
  TriangleMesh mesh = unit_ball();
  for (Vec3& x : mesh.vertices) x = ellipsoid.center + ellipsoid.radii.cwiseProduct(x);
  return mesh;
}

TriangleMesh surface(const Sphere& sphere, const Bounds& window) {
  return surface(Ellipsoid{sphere.center, Vec3::Constant(sphere.radius)}, window);
}

TriangleMesh surface(const Cylinder& cylinder, const Bounds&) {
  const double length = (cylinder.end - cylinder.start).norm(), radius = cylinder.radius;
  return revolve(cylinder.start, (cylinder.end - cylinder.start) / length,
                 {{0.0, 0.0}, {radius, 0.0}, {radius, length}, {0.0, length}});
}

TriangleMesh surface(const Capsule& capsule, const Bounds&) {
  const double length = (capsule.end - capsule.start).norm();
  std::vector<ProfilePoint> profile;
  add_arc(profile, capsule.radius, 0.0, -90.0, 0.0);
  if (!(length > 0.0)) profile.pop_back();  // a ball: its equator is there once
  add_arc(profile, capsule.radius, length, 0.0, 90.0);
  return revolve(capsule.start, length > 0.0 ? Vec3((capsule.end - capsule.start) / length) : Vec3::UnitZ(), profile);
}

TriangleMesh surface(const Mesh& mesh, const Bounds&) { return mesh.solid ? mesh.solid->mesh() : TriangleMesh{}; }

TriangleMesh surface(const Plane& plane, const Bounds& window) {
  TriangleMesh mesh;
  std::vector<Vec3> cap;
  for (const auto& face : box_faces) {
    std::vector<Vec3> polygon;
    for (const int corner : face) polygon.push_back(corner_of(window.lower, window.upper, corner));
    append_fan(mesh, clipped(polygon, plane, cap));
  }
  order_around(cap, plane.normal.normalized());
  append_fan(mesh, cap);
  weld(mesh);
  return mesh;
}

TriangleMesh surface(const Complement& complement, const Bounds& window) {
  return traced_in_window(Shape{complement}, window);
}

TriangleMesh surface(const Difference& difference, const Bounds& window) {
  const Shape shape{difference};
  return is_bounded(shape) ? traced(shape, bounds(shape)) : traced_in_window(shape, window);
}

TriangleMesh surface(const Union& all, const Bounds& window) {
  TriangleMesh mesh;
  for (const Shape& part : all.parts) append(mesh, surface_of(part, window));
  return mesh;
}

TriangleMesh surface(const Placed& placed, const Bounds& window) {
  const Mat3 turn = Eigen::AngleAxisd(placed.angle, placed.axis.normalized()).toRotationMatrix();
  const auto place = [&](const Vec3& x) { return Vec3(turn * (x - placed.origin) + placed.origin + placed.translation); };
  if (const auto* plane = std::get_if<Plane>(&placed.part->kind))
    return surface(Plane{place(plane->point), turn * plane->normal}, window);
  if (!is_bounded(*placed.part)) return traced_in_window(Shape{placed}, window);
  TriangleMesh mesh = surface_of(*placed.part, window);
  for (Vec3& x : mesh.vertices) x = place(x);
  return mesh;
}

}  // namespace

TriangleMesh surface_of(const Shape& shape, const Bounds& window) {
  return std::visit([&](const auto& kind) { return surface(kind, window); }, shape.kind);
}

}  // namespace bulkley
