#include "geometry/thickness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace bulkley {

namespace {

constexpr double n_lattice_points = 30000.0;
constexpr double thin_part = 0.1;  // of the surface that may be thinner

/// Length of the shape straight inwards from a point of its surface, at most `enough`.
double depth_behind(const Shape& shape, const Vec3& surface, const Vec3& normal, double enough) {
  const double smallest_stride = 0.01 * enough;
  double depth = smallest_stride;
  while (depth < enough) {
    const double inside = -signed_distance(shape, surface - depth * normal);
    if (inside <= 0.0) return depth;
    depth += std::max(inside, smallest_stride);
  }
  return enough;
}

struct Lattice {
  Int3 n;          ///< points along each axis
  double spacing;  ///< m, along all axes that have more than two
};

/// About n_lattice_points over a box, at least two along each axis however flat or slender it is.
Lattice lattice_over(const Vec3& size) {
  Lattice result{{2, 2, 2}, 0.0};
  std::array<int, 3> axes{0, 1, 2};
  std::sort(axes.begin(), axes.end(), [&](int a, int b) { return size[a] < size[b]; });
  double points = n_lattice_points;
  // The short axes first: where two points are already too many, the rest is divided among the longer axes.
  for (std::size_t shorter = 0; shorter < 3; ++shorter) {
    double volume = 1.0;
    for (std::size_t a = shorter; a < 3; ++a) volume *= size[axes[a]] / size[axes[shorter]];
    const double n = std::pow(points / volume, 1.0 / static_cast<double>(3 - shorter));  // along the shortest that is left
    result.spacing = size[axes[shorter]] / n;
    if (n <= 2.0) {
      points /= 2.0;
      continue;
    }
    for (std::size_t a = shorter; a < 3; ++a)
      result.n[static_cast<std::size_t>(axes[a])] =
          static_cast<int>(std::ceil(std::min(size[axes[a]] / result.spacing, n_lattice_points)));
    break;
  }
  return result;
}

}  // namespace

double thickness(const Shape& shape, const Bounds& window, double enough) {
  const Bounds own = bounds(shape);
  const Vec3 lower = own.lower.cwiseMax(window.lower), upper = own.upper.cwiseMin(window.upper);
  const Vec3 size = upper - lower;
  if (!(size.minCoeff() > 0.0) || !size.allFinite()) return enough;
  const auto [n, spacing] = lattice_over(size);

  std::vector<double> depths;
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        Vec3 x = lower + Vec3((i + 0.5) / n[0], (j + 0.5) / n[1], (k + 0.5) / n[2]).cwiseProduct(size);
        double distance = signed_distance(shape, x);
        if (std::abs(distance) > spacing) continue;
        // Distances may be bounds only: continue until the surface is reached.
        for (int step = 0; step < 5 && std::abs(distance) > 1e-3 * enough; ++step) {
          x -= distance * outward_normal(shape, x);
          distance = signed_distance(shape, x);
        }
        if (std::abs(distance) > 1e-3 * enough) continue;
        depths.push_back(depth_behind(shape, x, outward_normal(shape, x), enough));
      }
  if (depths.empty()) return enough;
  const auto quantile = depths.begin() + static_cast<std::ptrdiff_t>(thin_part * static_cast<double>(depths.size()));
  std::nth_element(depths.begin(), quantile, depths.end());
  return *quantile;
}

}  // namespace bulkley
