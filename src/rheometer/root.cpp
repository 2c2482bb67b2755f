#include "rheometer/root.hpp"

#include <algorithm>
#include <cmath>

namespace bulkley::rheometer {

namespace {

struct Point {
  double x, f;
};

// Walks against the sign of f until it changes.
std::optional<Point> other_side(const RootSearch& search, Point& near, const std::function<double(double)>& f) {
  const double direction = near.f < 0.0 ? 1.0 : -1.0;
  for (double step = search.first_step;; step *= 8.0) {
    const double x = std::clamp(search.start + direction * step, -search.largest, search.largest);
    const Point next{x, f(x)};
    if (!std::isfinite(next.f)) return std::nullopt;
    if ((next.f < 0.0) != (near.f < 0.0) || std::fabs(next.f) <= search.tolerance) return next;
    if (std::fabs(x) == search.largest) return std::nullopt;
    near = next;
  }
}

}  // namespace

std::optional<double> find_root(const RootSearch& search, const std::function<double(double)>& f) {
  Point a{search.start, f(search.start)};
  if (!std::isfinite(a.f)) return std::nullopt;
  if (std::fabs(a.f) <= search.tolerance) return a.x;
  const std::optional<Point> across = other_side(search, a, f);
  if (!across) return std::nullopt;
  Point b = *across;
  constexpr int cap = 200;
  for (int k = 0; k < cap && std::fabs(b.f) > search.tolerance; ++k) {
    double x = (a.x * b.f - b.x * a.f) / (b.f - a.f);
    // Where regula falsi crawls, as at a kink between slopes of very different size, halving does not.
    if (k % 4 == 3 || !(x > std::min(a.x, b.x) && x < std::max(a.x, b.x))) x = 0.5 * (a.x + b.x);
    if (x == a.x || x == b.x) break;  // no number between them
    const Point next{x, f(x)};
    if (!std::isfinite(next.f)) return std::nullopt;
    if ((next.f < 0.0) == (b.f < 0.0))
      a.f *= 0.5;
    else
      a = b;
    b = next;
  }
  return b.x;
}

}  // namespace bulkley::rheometer
