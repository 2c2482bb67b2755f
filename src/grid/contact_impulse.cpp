#include "grid/contact_impulse.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

constexpr std::size_t words_of_three = 6;

Vec3 three_of(const ExactSums& sums, std::size_t collider) {
  return {sums.value(3 * collider), sums.value(3 * collider + 1), sums.value(3 * collider + 2)};
}

}  // namespace

ContactImpulses::ContactImpulses(std::size_t n_colliders, double cell_mass, double length)
    : impulses_(3 * n_colliders, cell_mass), angular_impulses_(3 * n_colliders, std::ldexp(cell_mass, std::ilogb(length))) {}

void ContactImpulses::add(std::size_t collider, const Vec3& impulse, const Vec3& arm) {
  const Vec3 angular = arm.cross(impulse);
  for (int a = 0; a < 3; ++a) {
    const std::size_t place = 3 * collider + static_cast<std::size_t>(a);
    impulses_.add(place, impulse[a]);
    angular_impulses_.add(place, angular[a]);
  }
}

void ContactImpulses::add(const ContactImpulses& other) {
  impulses_.add(other.impulses_);
  angular_impulses_.add(other.angular_impulses_);
}

void ContactImpulses::clear() {
  impulses_.clear();
  angular_impulses_.clear();
}

Vec3 ContactImpulses::impulse(std::size_t collider) const { return three_of(impulses_, collider); }

Vec3 ContactImpulses::angular_impulse(std::size_t collider) const { return three_of(angular_impulses_, collider); }

// Collider by collider: those of its impulse, then those of its angular impulse.
std::vector<std::int64_t> ContactImpulses::words() const {
  const std::vector<std::int64_t> impulses = impulses_.words(), angular = angular_impulses_.words();
  std::vector<std::int64_t> result;
  for (std::size_t first = 0; first < impulses.size(); first += words_of_three)
    for (const std::vector<std::int64_t>* const words : {&impulses, &angular})
      for (std::size_t w = 0; w < words_of_three; ++w) result.push_back((*words)[first + w]);
  return result;
}

void ContactImpulses::set_words(std::span<const std::int64_t> words) {
  BULKLEY_ASSERT(words.size() == 2 * words_of_three * n_colliders());
  std::vector<std::int64_t> impulses, angular;
  for (std::size_t w = 0; w < words.size(); ++w)
    (w % (2 * words_of_three) < words_of_three ? impulses : angular).push_back(words[w]);
  impulses_.set_words(impulses);
  angular_impulses_.set_words(angular);
}

}  // namespace bulkley
