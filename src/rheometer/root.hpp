#pragma once
// Root of a rising function of one variable that is expensive to evaluate and known only by its values.

#include <functional>
#include <limits>
#include <optional>

namespace bulkley::rheometer {

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

struct RootSearch {
  double start;       ///< where to look first
  double first_step;  ///< > 0, size of the first step away from it; later ones are 8 times as large each
  double largest;     ///< bound of |x|
  double tolerance;   ///< largest |f| that counts as 0
};

/// x with |f(x)| <= tolerance, or the x next to which f jumps across 0 by more; nothing when f keeps its sign or is not a
/// number on the way. f was evaluated at the x returned last. By bracketing, then regula falsi of the Illinois kind, with
/// halvings between. Not collective.
std::optional<double> find_root(const RootSearch& search, const std::function<double(double)>& f);

}  // namespace bulkley::rheometer
