#include "magnetics/elliptic.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace bulkley {

double complete_elliptic(double kc, double p, double a, double b) {
  if (!(p > 0.0) || !(std::abs(kc) > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  constexpr double tolerance = 1e-8;  // convergence is quadratic: the last step squares it
  double k = std::abs(kc);
  double product = k;  // of the arithmetic-geometric mean's two numbers
  double mean = 1.0;
  double root = std::sqrt(p);
  b /= root;
  for (;;) {
    const double a_before = a;
    a += b / root;
    const double ratio = product / root;
    b = 2.0 * (b + a_before * ratio);
    root += ratio;
    const double mean_before = mean;
    mean += k;
    if (std::abs(mean_before - k) <= mean_before * tolerance) break;
    k = 2.0 * std::sqrt(product);
    product = k * mean;
  }
  return 0.5 * std::numbers::pi * (b + a * mean) / (mean * (mean + root));
}

}  // namespace bulkley
