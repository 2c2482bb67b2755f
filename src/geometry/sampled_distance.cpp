#include "geometry/sampled_distance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

constexpr double most_blocks = 2e8;  ///< four bytes each

std::size_t as_size(int n) { return static_cast<std::size_t>(n); }

}  // namespace

SampledDistance::SampledDistance(std::shared_ptr<const MeshSolid> solid, double spacing, double band)
    : solid_(std::move(solid)), spacing_(spacing), band_(band) {
  lower_ = solid_->facts().lower - Vec3::Constant(band);
  const Vec3 n = ((solid_->facts().upper - solid_->facts().lower).array() + 2.0 * band) / (width * spacing);
  if (!(n.array().ceil().prod() <= most_blocks))
    throw UsageError(fmt::format("is {:.4g} m large, too many cells for a collider; was its 'scale' forgotten?",
                                 (solid_->facts().upper - solid_->facts().lower).maxCoeff()));
  for (int a = 0; a < 3; ++a) {
    n_blocks_[as_size(a)] = static_cast<int>(std::ceil(n[a]));
    upper_[a] = lower_[a] + n_blocks_[as_size(a)] * width * spacing;
  }
  block_at_.assign(as_size(n_blocks_[0]) * as_size(n_blocks_[1]) * as_size(n_blocks_[2]), unknown);
}

std::int32_t SampledDistance::sample(const Int3& block) const {
  const Vec3 corner = lower_ + spacing_ * width * Vec3(block[0], block[1], block[2]);
  const double edge = spacing_ * width;
  const Vec3 center = corner + Vec3::Constant(0.5 * edge);
  const double reach = band_ + 0.5 * std::sqrt(3.0) * edge;
  const double at_center = solid_->signed_distance(center, 1.01 * reach);
  if (std::abs(at_center) > reach) return at_center > 0.0 ? outside : inside;
  Block& values = blocks_.emplace_back();
  std::size_t n = 0;
  for (int i = 0; i <= width; ++i)
    for (int j = 0; j <= width; ++j)
      for (int k = 0; k <= width; ++k) {
        // From the lattice's own indices: a point on the face of two blocks has the same bits in both.
        const Vec3 point = lower_ + spacing_ * Vec3(block[0] * width + i, block[1] * width + j, block[2] * width + k);
        values[n++] = static_cast<float>(std::clamp(solid_->signed_distance(point, band_), -band_, band_));
      }
  return static_cast<std::int32_t>(blocks_.size() - 1);
}

SampledDistance::Place SampledDistance::place(const Vec3& x) const {
  Place result;
  const Vec3 at = (x - lower_) / spacing_;
  for (int a = 0; a < 3; ++a) {
    const int cell = std::clamp(static_cast<int>(at[a]), 0, n_blocks_[as_size(a)] * width - 1);
    result.block[as_size(a)] = cell / width;
    result.in_block[as_size(a)] = cell % width;
    result.fraction[a] = at[a] - cell;
  }
  const Int3& block = result.block;
  result.index = (as_size(block[0]) * as_size(n_blocks_[1]) + as_size(block[1])) * as_size(n_blocks_[2]) + as_size(block[2]);
  return result;
}

double SampledDistance::distance(const Vec3& x) const {
  const double beyond = (lower_ - x).cwiseMax(x - upper_).cwiseMax(0.0).norm();
  if (!(beyond == 0.0)) return band_ + beyond;
  const auto [block, in_block, t, index] = place(x);
  if (block_at_[index] == unknown) block_at_[index] = sample(block);
  if (block_at_[index] < 0) return block_at_[index] == outside ? band_ : -band_;
  constexpr std::size_t row = width + 1, plane = row * row;
  const float* v =
      &blocks_[as_size(block_at_[index])][as_size(in_block[0]) * plane + as_size(in_block[1]) * row + as_size(in_block[2])];
  const double z = t[2], y = t[1];
  const auto along_z = [v, z](std::size_t at) { return (1.0 - z) * v[at] + z * v[at + 1]; };
  const auto along_y = [along_z, y](std::size_t at) { return (1.0 - y) * along_z(at) + y * along_z(at + row); };
  return (1.0 - t[0]) * along_y(0) + t[0] * along_y(plane);
}

Vec3 SampledDistance::normal(const Vec3& x) const {
  Vec3 difference;
  for (int a = 0; a < 3; ++a) {
    const Vec3 half = 0.5 * spacing_ * Vec3::Unit(a);
    difference[a] = distance(x + half) - distance(x - half);
  }
  const double length = difference.norm();
  return length > 0.1 * spacing_ ? Vec3(difference / length) : normal_of_block(x);
}

Vec3 SampledDistance::normal_of_block(const Vec3& x) const {
  const Vec3 inside_lattice = x.cwiseMax(lower_).cwiseMin(upper_);
  if (inside_lattice != x) return (x - inside_lattice).normalized();
  const Place at = place(x);
  const auto [found, is_new] = normals_.try_emplace(at.index);
  if (is_new) {
    const Vec3 middle = Vec3(at.block[0], at.block[1], at.block[2]) + Vec3::Constant(0.5);
    found->second = solid_->outward_normal(lower_ + spacing_ * width * middle);
  }
  return found->second;
}

}  // namespace bulkley
