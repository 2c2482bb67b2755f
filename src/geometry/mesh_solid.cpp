#include "geometry/mesh_solid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace bulkley {

namespace {

constexpr int leaf_size = 4;
constexpr double dipole_reach = 2.5;  ///< in radii of a cluster; beyond it is a dipole
constexpr int deepest = 64;           ///< halving 2^31 triangles takes 31 levels

/// The point of triangle (a, b, c) nearest to x, by the region of the plane that x lies over (Ericson 2005, section 5.1.5).
Vec3 nearest_in_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const Vec3 ab = b - a, ac = c - a, ax = x - a;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Vec3 bx = x - b;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const Vec3 cx = x - c;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double total = va + vb + vc;
  return a + vb / total * ab + vc / total * ac;
}

/// Solid angle of a triangle seen from x, over 4 pi; positive from behind (Van Oosterom and Strackee 1983).
double winding_of_triangle(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c, const Vec3& x) {
  const Vec3 a = corner_a - x, b = corner_b - x, c = corner_c - x;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double triple = a.dot(b.cross(c));
  const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(triple, rest) / (2.0 * std::numbers::pi);
}

double squared_distance_to_box(const Vec3& lower, const Vec3& upper, const Vec3& x) {
  return (lower - x).cwiseMax(x - upper).cwiseMax(0.0).squaredNorm();
}

/// The fraction of the distance to the triangles that is certainly free of the surface of winding number 1/2, from the
/// winding number that a closed mesh would not have here: on the axis of a round flat hole exactly 1 - 2 `excess`, beside a
/// straight rim no less. An excess of up to 0.05 may be the error of the dipoles.
double free_share(double excess) { return std::clamp((1.0 - 2.0 * excess) / 0.9, 0.0, 1.0); }

}  // namespace

MeshSolid::MeshSolid(TriangleMesh mesh)
    : mesh_(std::move(mesh)), facts_(bulkley::facts(mesh_)), sense_(facts_.volume < 0.0 ? -1.0 : 1.0) {
  const auto n = static_cast<int>(mesh_.triangles.size());
  for (const Int3& t : mesh_.triangles) {
    const auto at = [&](std::size_t corner) { return mesh_.vertices[static_cast<std::size_t>(t[corner])]; };
    triangles_.push_back({at(0), at(1), at(2)});
  }
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(static_cast<std::size_t>(n));
  build(order, 0, n);
  std::vector<Triangle> sorted;
  sorted.reserve(order.size());
  for (const int t : order) sorted.push_back(triangles_[static_cast<std::size_t>(t)]);
  triangles_ = std::move(sorted);
  // The nodes were made with the triangles in the order of the mesh; their sums need those in the order of the leaves.
  std::vector<int> last(nodes_.size());
  for (std::size_t at = nodes_.size(); at-- > 0;) {
    Node& node = nodes_[at];
    last[at] = node.count > 0 ? node.first + node.count : last[static_cast<std::size_t>(node.first)];
    std::size_t leaf = at;
    while (nodes_[leaf].count == 0) ++leaf;
    summarise(node, nodes_[leaf].first, last[at]);
  }
}

int MeshSolid::build(std::vector<int>& order, int first, int last) {
  const auto index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  if (last - first <= leaf_size) {
    nodes_.back().first = first;
    nodes_.back().count = last - first;
    return index;
  }
  const auto middle_of = [&](int t) {
    const Triangle& triangle = triangles_[static_cast<std::size_t>(t)];
    return Vec3(triangle.a + triangle.b + triangle.c);
  };
  Vec3 lower = middle_of(order[static_cast<std::size_t>(first)]), upper = lower;
  for (int n = first; n < last; ++n) {
    const Vec3 middle = middle_of(order[static_cast<std::size_t>(n)]);
    lower = lower.cwiseMin(middle);
    upper = upper.cwiseMax(middle);
  }
  int axis = 0;
  (upper - lower).maxCoeff(&axis);
  const int half = first + (last - first) / 2;
  std::nth_element(order.begin() + first, order.begin() + half, order.begin() + last, [&](int s, int t) {
    const double a = middle_of(s)[axis], b = middle_of(t)[axis];
    return a < b || (a == b && s < t);  // a total order: the tree does not depend on the library's algorithm
  });
  build(order, first, half);
  const int second = build(order, half, last);
  nodes_[static_cast<std::size_t>(index)].first = second;
  nodes_[static_cast<std::size_t>(index)].count = 0;
  return index;
}

void MeshSolid::summarise(Node& node, int first, int last) const {
  node.lower = node.upper = triangles_[static_cast<std::size_t>(first)].a;
  node.area = Vec3::Zero();
  Vec3 weighted = Vec3::Zero();
  double total = 0.0;
  for (int n = first; n < last; ++n) {
    const auto& [a, b, c] = triangles_[static_cast<std::size_t>(n)];
    node.lower = node.lower.cwiseMin(a).cwiseMin(b).cwiseMin(c);
    node.upper = node.upper.cwiseMax(a).cwiseMax(b).cwiseMax(c);
    const Vec3 area = 0.5 * (b - a).cross(c - a);
    node.area += area;
    weighted += area.norm() / 3.0 * (a + b + c);
    total += area.norm();
  }
  node.center = total > 0.0 ? Vec3(weighted / total) : Vec3(0.5 * (node.lower + node.upper));
  double radius_squared = 0.0;
  for (int n = first; n < last; ++n)
    for (const Vec3& corner : {triangles_[static_cast<std::size_t>(n)].a, triangles_[static_cast<std::size_t>(n)].b,
                               triangles_[static_cast<std::size_t>(n)].c})
      radius_squared = std::max(radius_squared, (corner - node.center).squaredNorm());
  node.near_squared = dipole_reach * dipole_reach * radius_squared;
}

double MeshSolid::winding_number(const Vec3& x) const {
  double exact = 0.0, dipoles = 0.0;
  std::array<int, deepest> waiting;
  int n_waiting = 0;
  int at = 0;
  while (true) {
    const Node& node = nodes_[static_cast<std::size_t>(at)];
    const Vec3 to_center = node.center - x;
    const double squared = to_center.squaredNorm();
    if (squared > node.near_squared) {
      dipoles += node.area.dot(to_center) / (squared * std::sqrt(squared));
    } else if (node.count == 0) {
      waiting[static_cast<std::size_t>(n_waiting++)] = node.first;
      ++at;
      continue;
    } else {
      for (int n = node.first; n < node.first + node.count; ++n) {
        const auto& [a, b, c] = triangles_[static_cast<std::size_t>(n)];
        exact += winding_of_triangle(a, b, c, x);
      }
    }
    if (n_waiting == 0) break;
    at = waiting[static_cast<std::size_t>(--n_waiting)];
  }
  return sense_ * (exact + dipoles / (4.0 * std::numbers::pi));
}

MeshSolid::Nearest MeshSolid::nearest(const Vec3& x, double reach) const {
  struct Waiting {
    int node;
    double squared;
  };
  std::array<Waiting, deepest> waiting;
  int n_waiting = 0;
  Nearest best{Vec3::Zero(), reach, 0};
  double best_squared = reach * reach;
  waiting[static_cast<std::size_t>(n_waiting++)] = {0, squared_distance_to_box(nodes_[0].lower, nodes_[0].upper, x)};
  while (n_waiting > 0) {
    const Waiting next = waiting[static_cast<std::size_t>(--n_waiting)];
    if (next.squared >= best_squared) continue;
    int at = next.node;
    while (nodes_[static_cast<std::size_t>(at)].count == 0) {  // down the nearer child
      const int left = at + 1, right = nodes_[static_cast<std::size_t>(at)].first;
      const Node &a = nodes_[static_cast<std::size_t>(left)], &b = nodes_[static_cast<std::size_t>(right)];
      const double to_left = squared_distance_to_box(a.lower, a.upper, x);
      const double to_right = squared_distance_to_box(b.lower, b.upper, x);
      const bool left_first = to_left <= to_right;
      if (std::max(to_left, to_right) < best_squared)
        waiting[static_cast<std::size_t>(n_waiting++)] = {left_first ? right : left, std::max(to_left, to_right)};
      at = left_first ? left : right;
    }
    const Node& leaf = nodes_[static_cast<std::size_t>(at)];
    for (int n = leaf.first; n < leaf.first + leaf.count; ++n) {
      const auto& [a, b, c] = triangles_[static_cast<std::size_t>(n)];
      const Vec3 point = nearest_in_triangle(a, b, c, x);
      const double squared = (point - x).squaredNorm();
      if (!(squared < best_squared)) continue;
      best_squared = squared;
      best = {point, std::sqrt(squared), n};
    }
  }
  return best;
}

double MeshSolid::distance_to_bounds(const Vec3& x) const {
  const Vec3 beyond = (facts_.lower - x).cwiseMax(x - facts_.upper);
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

bool MeshSolid::contains(const Vec3& x) const { return distance_to_bounds(x) <= 0.0 && winding_number(x) > 0.5; }

double MeshSolid::signed_distance(const Vec3& x, double reach) const {
  if (facts_.closed()) return contains(x) ? -nearest(x, reach).distance : nearest(x, reach).distance;
  const double w = winding_number(x);
  const double share = free_share(w > 0.5 ? 1.0 - w : w);
  const double distance = share > 0.0 ? share * nearest(x, reach / share).distance : 0.0;
  // The surface of winding number 1/2 may bulge out of the bounds, which then close the hole.
  return std::max(w > 0.5 ? -distance : distance, distance_to_bounds(x));
}

Vec3 MeshSolid::outward_normal(const Vec3& x) const {
  const Nearest found = nearest(x);
  const Vec3 away = x - found.point;
  const double size = (facts_.upper - facts_.lower).norm();
  if (found.distance > 1e-12 * size) return (contains(x) ? -away : away) / found.distance;
  const auto& [a, b, c] = triangles_[static_cast<std::size_t>(found.triangle)];
  const Vec3 area = sense_ * (b - a).cross(c - a);
  return area.norm() > 0.0 ? Vec3(area.normalized()) : Vec3::UnitZ();
}

}  // namespace bulkley
