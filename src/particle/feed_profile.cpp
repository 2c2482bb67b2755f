#include "particle/feed_profile.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "particle/inflow.hpp"

namespace bulkley {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double smallest_term = 1e-12;  // of the series, against a value of about 1/2
constexpr int most_terms = 2000;

}  // namespace

OpenEnds open_ends(const GridGeometry& grid, const Faces& faces, const RectangleSection& section, const Vec3& center,
                   const Vec3& first, const Vec3& second) {
  OpenEnds open{};
  const Vec3 sides[2] = {0.5 * section.width * first, 0.5 * section.height * second};
  for (std::size_t s = 0; s < 2; ++s)
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(sides[s][axis]) < (1.0 - 1e-9) * sides[s].norm()) continue;
      const double half = std::abs(sides[s][axis]);
      const bool on_face[2] = {std::abs(center[axis] - half - grid.lower[axis]) < 1e-6 * grid.cell_size,
                               std::abs(center[axis] + half - grid.upper()[axis]) < 1e-6 * grid.cell_size};
      const std::size_t face = 2 * static_cast<std::size_t>(axis);
      for (std::size_t end = 0; end < 2; ++end) {
        const FaceKind kind = faces[face + end].kind;
        // Only across the whole domain does a periodic one continue the section.
        const bool passes = kind == FaceKind::slip || (kind == FaceKind::periodic && on_face[0] && on_face[1]);
        open[s][sides[s][axis] > 0.0 ? end : 1 - end] = on_face[end] && passes;
      }
    }
  return open;
}

SpeedShares::SpeedShares(const DiscSection& section) : kind_(Kind::disc), largest_(2.0) { half_[0] = section.radius; }

SpeedShares::SpeedShares(const RectangleSection& section, const OpenEnds& open) {
  const double sides[2] = {section.width, section.height};
  bool walled[2];
  for (std::size_t s = 0; s < 2; ++s) {
    walled[s] = !(open[s][0] && open[s][1]);
    const bool is_half = open[s][0] || open[s][1];  // of a flow that a plane of symmetry cuts in two
    half_[s] = is_half ? sides[s] : 0.5 * sides[s];
    middle_[s] = !is_half ? 0.0 : open[s][0] ? -0.5 * sides[s] : 0.5 * sides[s];
  }
  if (!walled[0] && !walled[1]) return;
  if (!walled[0] || !walled[1]) {
    kind_ = Kind::plane;
    narrow_ = walled[0] ? 0 : 1;
    largest_ = 1.5;
    return;
  }
  kind_ = Kind::duct;
  narrow_ = half_[0] <= half_[1] ? 0 : 1;
  ratio_ = half_[1 - narrow_] / half_[narrow_];
  double sum = 0.0;
  for (int n = 1; n < most_terms; n += 2) sum += std::tanh(0.5 * pi * n * ratio_) / std::pow(n, 5);
  mean_ = 1.0 / 3.0 - 64.0 / (std::pow(pi, 5) * ratio_) * sum;
  largest_ = duct(0.0, 0.0).value / mean_;
}

SpeedShares::Share SpeedShares::duct(double x, double y) const {
  Share share{0.5 * (1.0 - x * x), {-x, 0.0}};
  // cosh(n pi y / 2) / cosh(n pi ratio / 2) = (near^n + far^n) / (1 + end^n)
  const double near = std::exp(0.5 * pi * (std::abs(y) - ratio_)), far = std::exp(-0.5 * pi * (std::abs(y) + ratio_)),
               end = std::exp(-pi * ratio_);
  double near_n = near, far_n = far, end_n = end, sign = 16.0 / (pi * pi * pi);
  for (int n = 1; n < most_terms; n += 2) {
    const double cubed = 1.0 * n * n * n, wave = 0.5 * pi * n, factor = sign / (cubed * (1.0 + end_n));
    share.value -= factor * (near_n + far_n) * std::cos(wave * x);
    share.slope[0] += factor * (near_n + far_n) * wave * std::sin(wave * x);
    share.slope[1] -= factor * (near_n - far_n) * wave * std::cos(wave * x) * (y < 0.0 ? -1.0 : 1.0);
    if (near_n < smallest_term * cubed) break;
    near_n *= near * near;
    far_n *= far * far;
    end_n *= end * end;
    sign = -sign;
  }
  return share;
}

SpeedShares::Share SpeedShares::at(double a, double b) const {
  if (kind_ == Kind::plug) return {};
  const double place[2] = {a - middle_[0], b - middle_[1]};
  if (kind_ == Kind::disc) {
    const double square = half_[0] * half_[0], inside = 1.0 - (place[0] * place[0] + place[1] * place[1]) / square;
    if (!(inside > 0.0)) return {0.0, {0.0, 0.0}};
    return {2.0 * inside, {-4.0 * place[0] / square, -4.0 * place[1] / square}};
  }
  const double x = place[narrow_] / half_[narrow_];
  Share share{0.0, {0.0, 0.0}};
  if (!(std::abs(x) < 1.0)) return share;
  if (kind_ == Kind::plane) {
    share.value = 1.5 * (1.0 - x * x);
    share.slope[narrow_] = -3.0 * x / half_[narrow_];
    return share;
  }
  const double y = place[1 - narrow_] / half_[narrow_];
  if (!(std::abs(y) < ratio_)) return share;
  const Share raw = duct(x, y);
  share.value = std::max(0.0, raw.value / mean_);
  share.slope[narrow_] = raw.slope[0] / (mean_ * half_[narrow_]);
  share.slope[1 - narrow_] = raw.slope[1] / (mean_ * half_[narrow_]);
  return share;
}

}  // namespace bulkley
