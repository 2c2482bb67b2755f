#pragma once
// First guesses for the root of (T21), so good that one step of Newton's method suffices.

#include <array>
#include <memory>

#include "bulkley/base/pack_math.hpp"

namespace bulkley {

/// What the flow return needs of eta and h and is expensive to compute. Never changes, so that copies of a law share it.
class OverstressTable {
 public:
  /// Requires eta >= 0 and h > 0. Not collective.
  OverstressTable(double eta, double h);

  double eta() const { return eta_; }
  double h() const { return h_; }
  double log_eta() const { return log_eta_; }

  /// ln xi where xi + A xi^m = 1, m = 1/h, within 4e-6 / max(1, m) for |t| < 15 and 0.1 <= h <= 3; with t = ln A for A < 1,
  /// else h ln A. Never above -h ln A, where A xi^m is 1. Not collective.
  template <class Real>
  Real log_remaining(Real log_A) const {
    const Real asymptote = log_A * -h_;
    const Real t = select(log_A < broadcast<Real>(0.0), log_A, -asymptote);
    const Real inside = maximum(minimum(t, broadcast<Real>(bound)), broadcast<Real>(-bound));  // also for NaN
    const Real position = (inside + bound) * pieces_per_unit;
    const Real shifted = (position - 0.5) + pack_math::to_integer;  // of two pieces that meet, either will do
    const Real x = position - (shifted - pack_math::to_integer);
    const Bits<Real> first = n_coefficients * (to_bits(shifted) - pack_math::to_integer_bits);
    Real c[n_coefficients];
    gather_rows(pieces_[0].data(), first, c);
    const Real u = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
    return minimum(u, asymptote);
  }

 private:
  static constexpr int bound = 16;  ///< e^-16 = 1e-7: beyond, ln xi is 0 or -h ln A for a first guess
  static constexpr int pieces_per_unit = 16;
  static constexpr int n_coefficients = 4;

  double eta_, h_, log_eta_;
  /// Cubics in t.
  alignas(32) std::array<std::array<double, n_coefficients>, 2 * bound * pieces_per_unit + 1> pieces_;
};

/// Null when eta or h is not a number, as in a law without parameters. Not collective.
std::shared_ptr<const OverstressTable> make_overstress_table(double eta, double h);

}  // namespace bulkley
