#include "stepping/impact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bulkley {

namespace {
// ||L||_max dx / U at its largest, in impacts that were run with APIC: 1.2 (a ball on a rough floor, 16 cells across), 1.4 and 2.0
// (a cylinder on a sticky floor, 16 and 32 cells). With moment_flip it is higher, 2.1 and 3.4.
constexpr double relative_gradient = 1.5;
constexpr int n_intervals = 2000;
}  // namespace

double largest_gradient(const Impact& impact, double cell_size, double time) {
  if (time < impact.time) return 0.0;
  const double passed = (time - impact.time) * impact.speed / impact.size;
  return relative_gradient * impact.speed / cell_size * std::pow(1.0 + passed, -impact.n_directions);
}

double count_steps(const TimeStepSettings& settings, double cell_size, double end, double dt,
                   const std::vector<Impact>& impacts) {
  if (impacts.empty()) return std::max(1.0, std::ceil(end / dt));
  const double interval = end / n_intervals;
  double n = 0.0;
  for (int k = 0; k < n_intervals; ++k) {
    StepBounds bounds;
    for (const Impact& impact : impacts)
      bounds.motion.velocity_gradient.include(largest_gradient(impact, cell_size, (k + 0.5) * interval), -1);
    n += interval / std::min(dt, time_step_limit(settings, cell_size, bounds, 0.0).dt);
  }
  return std::max(1.0, std::ceil(n * (1.0 - 1e-12)));
}

std::optional<double> first_contact(const Vec3& lower, const Vec3& upper, const Vec3& velocity, const Vec3& other_lower,
                                    const Vec3& other_upper) {
  double begin = 0.0, end = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double v = velocity[axis], ahead = other_lower[axis] - upper[axis], behind = other_upper[axis] - lower[axis];
    if (v == 0.0) {
      if (ahead > 0.0 || behind < 0.0) return std::nullopt;
      continue;
    }
    begin = std::max(begin, std::min(ahead / v, behind / v));
    end = std::min(end, std::max(ahead / v, behind / v));
  }
  return begin <= end ? std::optional(begin) : std::nullopt;
}

}  // namespace bulkley
