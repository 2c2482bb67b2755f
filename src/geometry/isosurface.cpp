#include "geometry/isosurface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

using Corner = Int3;  ///< lattice point

/// Six tetrahedra that share a cube's diagonal fill the cube, and meet those of the next cube face by face: each goes from one
/// corner to the opposite one, axis by axis in one of the six orders.
constexpr std::array<std::array<int, 3>, 6> axis_orders = {
    {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
constexpr int n_even_orders = 3;  ///< the first of them make right-handed tetrahedra

/// A vertex keeps this far from both ends of its edge, as a fraction, so that no triangle is without area.
constexpr double smallest_fraction = 1e-4;

class Marching {
 public:
  Marching(const std::function<double(const Vec3&)>& f, const Vec3& lower, const Vec3& upper, double spacing)
      : lower_(lower) {
    if (!(spacing > 0.0) || !((upper - lower).array() > 0.0).all())
      throw UsageError("an isosurface needs a spacing > 0 and a box with lower < upper");
    for (int a = 0; a < 3; ++a) {
      n_[static_cast<std::size_t>(a)] = std::max(2, static_cast<int>(std::ceil((upper[a] - lower[a]) / spacing - 1e-9)));
      step_[a] = (upper[a] - lower[a]) / n_[static_cast<std::size_t>(a)];
    }
    sample(f, upper);
  }

  TriangleMesh surface() {
    for (int i = 0; i < n_[0]; ++i)
      for (int j = 0; j < n_[1]; ++j)
        for (int k = 0; k < n_[2]; ++k) march_cube({i, j, k});
    return std::move(mesh_);
  }

 private:
  std::size_t index(const Corner& c) const {
    return (static_cast<std::size_t>(c[0]) * static_cast<std::size_t>(n_[1] + 1) + static_cast<std::size_t>(c[1])) *
               static_cast<std::size_t>(n_[2] + 1) +
           static_cast<std::size_t>(c[2]);
  }
  Vec3 place(const Corner& c) const { return lower_ + Vec3(c[0], c[1], c[2]).cwiseProduct(step_); }
  double value(const Corner& c) const { return values_[index(c)]; }

  /// The larger of f and the signed distance to the nearest face: the set cut by the box.
  void sample(const std::function<double(const Vec3&)>& f, const Vec3& upper) {
    values_.resize(index(n_) + 1);
    for (int i = 0; i <= n_[0]; ++i)
      for (int j = 0; j <= n_[1]; ++j)
        for (int k = 0; k <= n_[2]; ++k) {
          const Corner c{i, j, k};
          const Vec3 x = place(c);
          bool outermost = false;
          for (std::size_t a = 0; a < 3; ++a) outermost = outermost || c[a] == 0 || c[a] == n_[a];
          const double to_face = outermost ? 0.0 : (lower_ - x).cwiseMax(x - upper).maxCoeff();
          values_[index(c)] = std::max(f(x), to_face);
        }
  }

  /// The vertex where the surface crosses the edge from `inside` to `outside`.
  int vertex(const Corner& inside, const Corner& outside) {
    const Corner& first = std::min(inside, outside);  // along every axis, for corners of one tetrahedron
    const Corner& last = std::max(inside, outside);
    const int direction = (last[0] - first[0]) * 4 + (last[1] - first[1]) * 2 + (last[2] - first[2]);
    const auto [found, is_new] = vertex_of_edge_.try_emplace(index(first) * 8 + static_cast<std::size_t>(direction),
                                                             static_cast<int>(mesh_.vertices.size()));
    if (is_new) {
      const double a = value(inside), b = value(outside);
      const double fraction = std::clamp(a / (a - b), smallest_fraction, 1.0 - smallest_fraction);
      mesh_.vertices.push_back((1.0 - fraction) * place(inside) + fraction * place(outside));
    }
    return found->second;
  }

  void march_cube(const Corner& c) {
    bool any_inside = false, any_outside = false;
    for (int corner = 0; corner < 8; ++corner)
      (value({c[0] + (corner >> 2), c[1] + (corner >> 1 & 1), c[2] + (corner & 1)}) < 0.0 ? any_inside : any_outside) = true;
    if (!any_inside || !any_outside) return;
    for (std::size_t n = 0; n < axis_orders.size(); ++n) {
      std::array<Corner, 4> tetrahedron;
      tetrahedron.fill(c);
      for (std::size_t step = 0; step < 3; ++step)
        for (std::size_t later = step + 1; later < 4; ++later)
          ++tetrahedron[later][static_cast<std::size_t>(axis_orders[n][step])];
      if (n >= n_even_orders) std::swap(tetrahedron[1], tetrahedron[2]);
      march(tetrahedron);
    }
  }

  /// `t`: right-handed, which swapping two pairs of corners at once keeps.
  void march(std::array<Corner, 4> t) {
    std::array<bool, 4> in;
    for (std::size_t c = 0; c < 4; ++c) in[c] = value(t[c]) < 0.0;
    const auto n_inside = std::count(in.begin(), in.end(), true);
    if (n_inside == 0 || n_inside == 4) return;
    // To the front: the one corner that differs from the others, or the two that are inside.
    const bool wanted = n_inside != 3;
    const std::size_t n_front = n_inside == 2 ? 2 : 1;
    bool odd = false;
    for (std::size_t front = 0; front < n_front; ++front) {
      std::size_t c = front;
      while (in[c] != wanted) ++c;
      if (c == front) continue;
      std::swap(t[front], t[c]);
      std::swap(in[front], in[c]);
      odd = !odd;
    }
    if (odd) std::swap(t[2], t[3]);
    if (n_inside == 1) add(vertex(t[0], t[1]), vertex(t[0], t[2]), vertex(t[0], t[3]));
    if (n_inside == 3) add(vertex(t[1], t[0]), vertex(t[3], t[0]), vertex(t[2], t[0]));
    if (n_inside == 2) {
      const int a = vertex(t[0], t[2]), b = vertex(t[0], t[3]), c = vertex(t[1], t[3]), d = vertex(t[1], t[2]);
      add(a, b, c);
      add(a, c, d);
    }
  }

  void add(int a, int b, int c) { mesh_.triangles.push_back({a, b, c}); }

  Vec3 lower_, step_;
  Int3 n_;  ///< cubes along each axis
  std::vector<double> values_;
  std::unordered_map<std::size_t, int> vertex_of_edge_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh isosurface(const std::function<double(const Vec3&)>& f, const Vec3& lower, const Vec3& upper, double spacing) {
  return Marching(f, lower, upper, spacing).surface();
}

}  // namespace bulkley
