#include "geometry/contact_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/surface.hpp"

namespace bulkley {

namespace {

constexpr std::size_t most_points = 4096;
constexpr int n_edge_points = 16;  // of a cylinder's end

/// Points along a segment, its ends included.
std::vector<Vec3> along(const Vec3& start, const Vec3& end, double spacing) {
  const auto n = static_cast<int>(std::clamp(std::ceil((end - start).norm() / spacing), 1.0, 64.0));
  std::vector<Vec3> points;
  for (int i = 0; i <= n; ++i) points.push_back(start + (static_cast<double>(i) / n) * (end - start));
  return points;
}

std::vector<ContactPoint> points_of(const Capsule& capsule, double spacing) {
  std::vector<ContactPoint> points;
  for (const Vec3& x : along(capsule.start, capsule.end, spacing)) points.push_back({x, capsule.radius});
  return points;
}

std::vector<ContactPoint> points_of(const Cylinder& cylinder, double spacing) {
  const Vec3 axis = (cylinder.end - cylinder.start).normalized(), side = axis.unitOrthogonal(), other = axis.cross(side);
  std::vector<ContactPoint> points;
  for (const Vec3& x : along(cylinder.start, cylinder.end, spacing)) points.push_back({x, cylinder.radius, axis});
  for (const double sign : {-1.0, 1.0})
    for (int i = 0; i < n_edge_points; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / n_edge_points;
      points.push_back({(sign < 0.0 ? cylinder.start : cylinder.end) +
                            cylinder.radius * (std::cos(angle) * side + std::sin(angle) * other),
                        0.0, sign * axis});
    }
  return points;
}

/// A lattice on every triangle; vertices come first.
std::vector<ContactPoint> points_of(const TriangleMesh& mesh, double spacing) {
  std::vector<ContactPoint> points;
  const std::size_t stride = mesh.vertices.size() / most_points + 1;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += stride) points.push_back({mesh.vertices[v]});
  const auto n_of = [&](const Int3& t, double length) {
    double longest = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(
          longest,
          (mesh.vertices[static_cast<std::size_t>(t[i])] - mesh.vertices[static_cast<std::size_t>(t[(i + 1) % 3])]).norm());
    return std::max(1.0, std::ceil(longest / length));
  };
  const auto n_here = static_cast<double>(points.size());
  double length = spacing, n_more = 0.0;
  do {
    n_more = 0.0;
    for (const Int3& t : mesh.triangles) n_more += 0.5 * (n_of(t, length) + 1.0) * (n_of(t, length) + 2.0) - 3.0;
    if (n_here + n_more > most_points) length *= 1.25;
  } while (n_more > 0.0 && n_here + n_more > most_points);
  for (const Int3& t : mesh.triangles) {
    const int n = static_cast<int>(n_of(t, length));
    const auto corner = [&](int i) -> const Vec3& {
      return mesh.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(i)])];
    };
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const int k = n - i - j;
        if (i == n || j == n || k == n) continue;
        points.push_back({(i * corner(0) + j * corner(1) + k * corner(2)) / n});
      }
  }
  return points;
}

}  // namespace

std::vector<ContactPoint> contact_points(const Shape& shape, double spacing) {
  if (const auto* sphere = std::get_if<Sphere>(&shape.kind)) return {{sphere->center, sphere->radius}};
  if (const auto* capsule = std::get_if<Capsule>(&shape.kind)) return points_of(*capsule, spacing);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape.kind)) return points_of(*cylinder, spacing);
  if (const auto* placed = std::get_if<Placed>(&shape.kind)) {
    const Mat3 turn = Eigen::AngleAxisd(placed->angle, placed->axis.normalized()).toRotationMatrix();
    const Pose pose{turn, placed->origin + placed->translation - turn * placed->origin};
    std::vector<ContactPoint> points = contact_points(*placed->part, spacing);
    for (ContactPoint& point : points) point = moved(point, pose);
    return points;
  }
  return points_of(surface_of(shape, bounds(shape)), spacing);
}

ContactPoint moved(const ContactPoint& point, const Pose& pose) {
  return {pose.to_world(point.place), point.radius, pose.rotation * point.axis};
}

}  // namespace bulkley
