#include "rheometer/steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley::rheometer {

int count_steps(double amount, double largest) {
  constexpr double most = 1e9;
  constexpr double rounding = 1e-9;  // 1 / 2e-4 is 5000 steps, not 5001
  const double n_steps = std::ceil(amount / largest - rounding);
  if (!(n_steps <= most))
    throw UsageError(
        fmt::format("the measurement would take {:.3g} steps, above {:g}; choose a smaller strain or duration, or a "
                    "larger --strain-per-step",
                    n_steps, most));
  return std::max(1, static_cast<int>(n_steps));
}

}  // namespace bulkley::rheometer
