#include "grid/gauge.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/surface.hpp"

namespace bulkley {

namespace {

struct Stretch {
  double begin, end;
  double length() const { return std::max(0.0, end - begin); }
};

struct Rectangle {
  Stretch x, y;
};

/// Area of the part of a disc of radius 1 around the origin with x < a and y < b.
double disc_corner(double a, double b) {
  const double end = std::clamp(a, -1.0, 1.0);
  const auto half_segment = [](double x) {  // integral of sqrt(1 - x^2) from 0
    return 0.5 * (x * std::sqrt(std::max(0.0, 1.0 - x * x)) + std::asin(std::clamp(x, -1.0, 1.0)));
  };
  const auto below_circle = [&](double from, double to) { return half_segment(to) - half_segment(from); };
  if (b <= -1.0) return 0.0;
  if (b >= 1.0) return 2.0 * below_circle(-1.0, end);
  const double s = std::sqrt(1.0 - b * b);  // where the circle meets y = b
  const double left = std::min(end, -s), middle = std::clamp(end, -s, s), right = std::max(end, s);
  double area = b * (middle + s) + below_circle(-s, middle);  // between the circle from below and y = b
  if (b > 0.0) area += 2.0 * (below_circle(-1.0, left) + below_circle(s, right));
  return area;
}

double disc_overlap(const Rectangle& r, double x, double y, double radius) {
  const double left = (r.x.begin - x) / radius, right = (r.x.end - x) / radius;
  const double lower = (r.y.begin - y) / radius, upper = (r.y.end - y) / radius;
  if (!(left < right && lower < upper) || left >= 1.0 || right <= -1.0 || lower >= 1.0 || upper <= -1.0) return 0.0;
  const double part =
      disc_corner(right, upper) - disc_corner(left, upper) - disc_corner(right, lower) + disc_corner(left, lower);
  return radius * radius * std::max(0.0, part);
}

/// A plane of the domain and its two axes.
struct FacePlane {
  int normal, first, second;
  double position;  // m
};

FacePlane plane_of(const GridGeometry& grid, FaceName face) {
  const int f = static_cast<int>(face), normal = f / 2;
  return {normal, normal == 0 ? 1 : 0, normal == 2 ? 1 : 2, f % 2 == 0 ? grid.lower[normal] : grid.upper()[normal]};
}

/// Area of the part of a rectangle on the face that belongs to the patch.
double patch_overlap(const GridGeometry& grid, const Gauge& gauge, const FacePlane& plane, const Rectangle& r) {
  const double near = 1e-6 * grid.cell_size;
  if (gauge.lower) {
    const Vec3 &lower = *gauge.lower, &upper = *gauge.upper;
    if (plane.position < lower[plane.normal] - near || plane.position > upper[plane.normal] + near) return 0.0;
    const Stretch x{std::max(r.x.begin, lower[plane.first]), std::min(r.x.end, upper[plane.first])};
    const Stretch y{std::max(r.y.begin, lower[plane.second]), std::min(r.y.end, upper[plane.second])};
    return x.length() * y.length();
  }
  if (gauge.center) {
    const Vec3& c = *gauge.center;
    const double depth = std::abs(c[plane.normal] - plane.position);
    const double squared = *gauge.radius * *gauge.radius - depth * depth;
    return squared > 0.0 ? disc_overlap(r, c[plane.first], c[plane.second], std::sqrt(squared)) : 0.0;
  }
  return r.x.length() * r.y.length();
}

/// The stretches of an axis that belong to a node: half a cell to both sides, within the domain.
std::vector<Stretch> stretches(const GridGeometry& grid, int axis, int node) {
  const double h = grid.cell_size, lower = grid.lower[axis], upper = grid.upper()[axis];
  const int n = grid.n_cells[static_cast<std::size_t>(axis)];
  const int i = std::clamp(node - grid.node_offset(axis), 0, n);
  if (grid.periodic[static_cast<std::size_t>(axis)] && i == 0) return {{lower, lower + 0.5 * h}, {upper - 0.5 * h, upper}};
  return {{i == 0 ? lower : lower + (i - 0.5) * h, i == n ? upper : lower + (i + 0.5) * h}};
}

bool is_inside(const Gauge& gauge, const Vec3& x) {
  if (gauge.lower) return (x.array() >= gauge.lower->array()).all() && (x.array() <= gauge.upper->array()).all();
  if (gauge.center) return (x - *gauge.center).squaredNorm() <= *gauge.radius * *gauge.radius;
  return true;
}

/// Distance from `x` to a box, m; 0 inside.
double distance_to_box(const Vec3& lower, const Vec3& upper, const Vec3& x) {
  return (x - x.cwiseMax(lower).cwiseMin(upper)).norm();
}

/// Distance from `x` to the box or ball, m; 0 inside.
double distance_to(const Gauge& gauge, const Vec3& x) {
  if (gauge.lower) return distance_to_box(*gauge.lower, *gauge.upper, x);
  if (gauge.center) return std::max(0.0, (x - *gauge.center).norm() - *gauge.radius);
  return 0.0;
}

using Triangle = std::array<Vec3, 3>;

double area_of(const Triangle& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm(); }

/// Area of the part of a triangle from whose points the convex set of distance `distance` is no farther than `near`; divided
/// down to edges of `finest`.
template <class Distance>
double area_inside(const Triangle& t, const Distance& distance, double near, double finest) {
  const auto inside = [&](const Vec3& x) { return distance(x) <= near; };
  if (inside(t[0]) && inside(t[1]) && inside(t[2])) return area_of(t);
  const Vec3 middle = (t[0] + t[1] + t[2]) / 3.0;
  const double size = std::max({(t[0] - middle).norm(), (t[1] - middle).norm(), (t[2] - middle).norm()});
  if (distance(middle) > size + near) return 0.0;
  const double longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  if (longest <= finest) return inside(middle) ? area_of(t) : 0.0;
  const Vec3 a = 0.5 * (t[0] + t[1]), b = 0.5 * (t[1] + t[2]), c = 0.5 * (t[2] + t[0]);
  double area = 0.0;
  for (const Triangle& part : {Triangle{t[0], a, c}, Triangle{a, t[1], b}, Triangle{c, b, t[2]}, Triangle{a, b, c}})
    area += area_inside(part, distance, near, finest);
  return area;
}

double collider_area(const GridGeometry& grid, const Gauge& gauge, const Collider& collider) {
  const Vec3 lower = grid.lower, upper = grid.upper();
  const TriangleMesh mesh = surface_of(collider.shape, {lower, upper});
  const double h = grid.cell_size, near = 1e-6 * h;
  const bool clips = !collider.motion.moves();
  const auto distance = [&](const Vec3& x) {
    return std::max(distance_to(gauge, x), clips ? distance_to_box(lower, upper, x) : 0.0);
  };
  const Bounds own = bounds(collider.shape);
  const bool is_endless = !own.lower.allFinite() || !own.upper.allFinite();
  double area = 0.0;
  for (const Int3& corners : mesh.triangles) {
    const Triangle t{mesh.vertices[static_cast<std::size_t>(corners[0])],
                     mesh.vertices[static_cast<std::size_t>(corners[1])],
                     mesh.vertices[static_cast<std::size_t>(corners[2])]};
    const Vec3 middle = (t[0] + t[1] + t[2]) / 3.0;
    const double size = std::max({(t[0] - middle).norm(), (t[1] - middle).norm(), (t[2] - middle).norm()});
    // The window's faces close what is endless: they are no part of its surface.
    if (is_endless && std::abs(signed_distance(collider.shape, middle)) > 0.01 * size + near) continue;
    area += area_inside(t, distance, near, h / 8.0);
  }
  return area;
}

}  // namespace

double face_share(const GridGeometry& grid, const Gauge& gauge, const Int3& node) {
  const FacePlane plane = plane_of(grid, *gauge.face);
  double whole = 0.0, part = 0.0;
  for (const Stretch& x : stretches(grid, plane.first, node[static_cast<std::size_t>(plane.first)]))
    for (const Stretch& y : stretches(grid, plane.second, node[static_cast<std::size_t>(plane.second)])) {
      whole += x.length() * y.length();
      part += patch_overlap(grid, gauge, plane, {x, y});
    }
  return std::min(1.0, part / whole);
}

double collider_share(const GridGeometry& grid, const Gauge& gauge, const Collider& collider, const Pose& pose,
                      const Vec3& position) {
  if (!gauge.lower && !gauge.center) return 1.0;
  constexpr int n = 8;
  const Vec3 x = pose.to_shape(position);
  const Vec3 normal = outward_normal(collider.shape, x);
  const Vec3 foot = x - signed_distance(collider.shape, x) * normal;
  if (distance_to(gauge, foot) > grid.cell_size) return 0.0;
  // Along the axes where the normal is: the axis with the smallest component of the normal is the most tangential.
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Vec3 first = normal.cross(Vec3::Unit(axis)).normalized(), second = normal.cross(first);
  int count = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double u = (i + 0.5) / n - 0.5, v = (j + 0.5) / n - 0.5;
      if (is_inside(gauge, foot + grid.cell_size * (u * first + v * second))) ++count;
    }
  return static_cast<double>(count) / (n * n);
}

double gauge_area(const GridGeometry& grid, const Gauge& gauge, const std::vector<Collider>& colliders) {
  if (!gauge.face) return collider_area(grid, gauge, colliders[static_cast<std::size_t>(gauge.collider_number)]);
  const FacePlane plane = plane_of(grid, *gauge.face);
  const Vec3 lower = grid.lower, upper = grid.upper();
  return patch_overlap(grid, gauge, plane,
                       {{lower[plane.first], upper[plane.first]}, {lower[plane.second], upper[plane.second]}});
}

GlobalIndex count_gauge_nodes(const GridGeometry& grid, const Gauge& gauge) {
  const FacePlane plane = plane_of(grid, *gauge.face);
  const auto first = static_cast<std::size_t>(plane.first), second = static_cast<std::size_t>(plane.second);
  const auto end = [&](int axis) {
    return grid.n_cells[static_cast<std::size_t>(axis)] + (grid.periodic[static_cast<std::size_t>(axis)] ? 0 : 1);
  };
  GlobalIndex count = 0;
  for (int i = 0; i < end(plane.first); ++i)
    for (int j = 0; j < end(plane.second); ++j) {
      Int3 node{0, 0, 0};
      node[first] = i + grid.node_offset(plane.first);
      node[second] = j + grid.node_offset(plane.second);
      if (face_share(grid, gauge, node) > 0.0) ++count;
    }
  return count;
}

}  // namespace bulkley
