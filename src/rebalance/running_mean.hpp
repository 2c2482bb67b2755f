#pragma once
// Means of measured times.

#include <algorithm>

namespace bulkley {

/// Lets a new measurement into a running mean, which single noisy ones hardly move: sometimes one takes very long for
/// reasons that have nothing to do with what is measured.
inline void average_in(double& mean, double value) {
  constexpr double newest_weight = 0.25;
  mean += newest_weight * (std::min(value, 2.0 * mean) - mean);
}

}  // namespace bulkley
