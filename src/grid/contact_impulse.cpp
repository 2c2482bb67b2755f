#include "grid/contact_impulse.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {
constexpr int digits_below_a_cell = 70;
}

ContactImpulses::ContactImpulses(std::size_t n_colliders, double cell_mass, double length)
    : sums_(6 * n_colliders, 0),
      impulse_exponent_(std::ilogb(cell_mass) - digits_below_a_cell),
      angular_exponent_(impulse_exponent_ + std::ilogb(length)) {}

ContactImpulses::Integer ContactImpulses::units(double value, int exponent) const {
  const double scaled = std::ldexp(value, -exponent);
  // Beyond 2^120 nothing physical is left; the cast would be undefined beyond 2^127.
  if (!(std::abs(scaled) < 0x1p120)) return 0;
  return static_cast<Integer>(std::nearbyint(scaled));
}

double ContactImpulses::number(std::size_t place, int exponent) const {
  return std::ldexp(static_cast<double>(sums_[place]), exponent);
}

void ContactImpulses::add(std::size_t collider, const Vec3& impulse, const Vec3& arm) {
  const Vec3 angular = arm.cross(impulse);
  for (int a = 0; a < 3; ++a) {
    const std::size_t place = 6 * collider + static_cast<std::size_t>(a);
    sums_[place] += units(impulse[a], impulse_exponent_);
    sums_[place + 3] += units(angular[a], angular_exponent_);
  }
}

void ContactImpulses::add(const ContactImpulses& other) {
  BULKLEY_ASSERT(sums_.size() == other.sums_.size() && impulse_exponent_ == other.impulse_exponent_);
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += other.sums_[i];
}

void ContactImpulses::clear() { sums_.assign(sums_.size(), 0); }

Vec3 ContactImpulses::impulse(std::size_t collider) const {
  const std::size_t i = 6 * collider;
  return {number(i, impulse_exponent_), number(i + 1, impulse_exponent_), number(i + 2, impulse_exponent_)};
}

Vec3 ContactImpulses::angular_impulse(std::size_t collider) const {
  const std::size_t i = 6 * collider + 3;
  return {number(i, angular_exponent_), number(i + 1, angular_exponent_), number(i + 2, angular_exponent_)};
}

std::vector<std::int64_t> ContactImpulses::words() const {
  std::vector<std::int64_t> result;
  for (const Integer sum : sums_) {
    result.push_back(static_cast<std::int64_t>(static_cast<std::uint64_t>(sum)));
    result.push_back(static_cast<std::int64_t>(sum >> 64));
  }
  return result;
}

void ContactImpulses::set_words(std::span<const std::int64_t> words) {
  BULKLEY_ASSERT(words.size() == 2 * sums_.size());
  for (std::size_t i = 0; i < sums_.size(); ++i)
    sums_[i] =
        (static_cast<Integer>(words[2 * i + 1]) << 64) | static_cast<Integer>(static_cast<std::uint64_t>(words[2 * i]));
}

}  // namespace bulkley
