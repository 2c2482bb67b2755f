#include "material/overstress_table.hpp"

#include <cmath>

#include "material/return_map.hpp"

namespace bulkley {

namespace {

struct Knot {
  double value;  ///< u = ln xi
  double slope;  ///< du / d ln A
};

Knot knot_at(double log_A, double m) {
  const OverstressSplit<double> split = split_overstress(log_A, m, true, nullptr);
  return {std::log(split.remaining), -split.relaxed / (split.remaining + m * split.relaxed)};
}

}  // namespace

OverstressTable::OverstressTable(double eta, double h) : eta_(eta), h_(h), log_eta_(std::log(eta)) {
  constexpr double width = 1.0 / pieces_per_unit;
  const double m = 1.0 / h;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const double t = static_cast<double>(i) * width - bound;
    const double scale = t < 0.0 ? 1.0 : m;  // ln A over t
    const Knot left = knot_at(t * scale, m), right = knot_at((t + width) * scale, m);
    const double left_slope = left.slope * scale * width, right_slope = right.slope * scale * width;
    const double rise = right.value - left.value;
    pieces_[i] = {left.value, left_slope, 3.0 * rise - 2.0 * left_slope - right_slope,
                  left_slope + right_slope - 2.0 * rise};
  }
}

std::shared_ptr<const OverstressTable> make_overstress_table(double eta, double h) {
  return eta >= 0.0 && h > 0.0 ? std::make_shared<const OverstressTable>(eta, h) : nullptr;
}

}  // namespace bulkley
