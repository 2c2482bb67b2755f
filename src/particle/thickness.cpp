#include "bulkley/particle/thickness.hpp"

#include <algorithm>
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

}  // namespace

double thickness(const Shape& shape, const Bounds& window, double enough) {
  const Bounds own = bounds(shape);
  const Vec3 lower = own.lower.cwiseMax(window.lower), upper = own.upper.cwiseMin(window.upper);
  const Vec3 size = upper - lower;
  if (!(size.minCoeff() > 0.0)) return enough;
  const double spacing = std::cbrt(size.prod() / n_lattice_points);
  Int3 n;
  for (int a = 0; a < 3; ++a) n[static_cast<std::size_t>(a)] = std::max(2, static_cast<int>(std::ceil(size[a] / spacing)));

  std::vector<double> depths;
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        Vec3 x = lower + Vec3((i + 0.5) / n[0], (j + 0.5) / n[1], (k + 0.5) / n[2]).cwiseProduct(size);
        double distance = signed_distance(shape, x);
        if (std::abs(distance) > spacing) continue;
        // Distances may be bounds only: go on until the surface is reached.
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
