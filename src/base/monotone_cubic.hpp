#pragma once
// Piecewise cubics with a continuous slope through points, without overshoot (Fritsch & Carlson 1980, slopes of Fritsch &
// Butland 1984).

#include <algorithm>
#include <cmath>

namespace bulkley {

/// Slope at a point between two segments: `before` and `after` are their secants, `h_before` and `h_after` their lengths. Zero
/// where the direction changes, else the weighted harmonic mean, which keeps the cubic monotone.
inline double monotone_slope(double before, double after, double h_before, double h_after) {
  if (before * after <= 0.0) return 0.0;
  const double w_before = h_before + 2.0 * h_after, w_after = 2.0 * h_before + h_after;
  return (w_before + w_after) / (w_before / before + w_after / after);
}

/// One segment, of length `h`: Hermite's cubic of the share s of it, 0 <= s <= 1.
struct Cubic {
  double h, start, end, start_slope, end_slope;

  double value(double s) const {
    const double r = 1.0 - s;
    return (1.0 + 2.0 * s) * r * r * start + s * r * r * h * start_slope + s * s * (3.0 - 2.0 * s) * end -
           s * s * r * h * end_slope;
  }
  double rate(double s) const {
    const double mean = (end - start) / h;
    return 6.0 * s * (1.0 - s) * mean + (1.0 - s) * (1.0 - 3.0 * s) * start_slope + s * (3.0 * s - 2.0) * end_slope;
  }
  /// Largest |rate| in the segment: at an end or where the quadratic turns.
  double largest_rate() const {
    const double mean = (end - start) / h;
    const double a = 3.0 * (start_slope + end_slope) - 6.0 * mean, b = 6.0 * mean - 4.0 * start_slope - 2.0 * end_slope;
    double largest = std::max(std::abs(start_slope), std::abs(end_slope));
    const double turn = a != 0.0 ? -0.5 * b / a : -1.0;
    if (turn > 0.0 && turn < 1.0) largest = std::max(largest, std::abs(rate(turn)));
    return largest;
  }
};

}  // namespace bulkley
