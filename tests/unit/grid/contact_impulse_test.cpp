#include "grid/contact_impulse.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "support/random_vectors.hpp"

namespace bulkley::contact_impulse_test {
namespace {

struct Push {
  Vec3 impulse, arm;
};

std::vector<Push> pushes(int n) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Push> result;
  for (int i = 0; i < n; ++i) {
    const double size = std::pow(10.0, 6.0 * uniform(random));
    const Vec3 impulse = size * random_vector(uniform, random);
    result.push_back({impulse, random_vector(uniform, random)});
  }
  return result;
}

TEST(ContactImpulses, AreTheSameInAnyOrderAndAnyShares) {
  std::vector<Push> all = pushes(1000);
  ContactImpulses forward(2, 1e-3, 1.0), backward = forward, first = forward, second = forward;
  for (const Push& push : all) forward.add(1, push.impulse, push.arm);
  for (std::size_t i = 0; i < all.size(); ++i) (i % 3 == 0 ? first : second).add(1, all[i].impulse, all[i].arm);
  std::reverse(all.begin(), all.end());
  for (const Push& push : all) backward.add(1, push.impulse, push.arm);
  first.add(second);
  EXPECT_EQ(forward.words(), backward.words());
  EXPECT_EQ(forward.words(), first.words());
  EXPECT_EQ(forward.impulse(0), Vec3(Vec3::Zero()));

  using Extended = Eigen::Matrix<long double, 3, 1>;
  Extended impulse = Extended::Zero(), angular = Extended::Zero();
  for (const Push& push : all) {
    impulse += push.impulse.cast<long double>();
    angular += Vec3(push.arm.cross(push.impulse)).cast<long double>();
  }
  EXPECT_LE((forward.impulse(1) - impulse.cast<double>()).norm(), 1e-15 * impulse.cast<double>().norm());
  EXPECT_LE((forward.angular_impulse(1) - angular.cast<double>()).norm(), 1e-15 * angular.cast<double>().norm());
}

TEST(ContactImpulses, CancelExactly) {
  ContactImpulses sums(1, 1e-3, 1.0);
  const std::vector<Push> all = pushes(100);
  for (const Push& push : all) sums.add(0, push.impulse, push.arm);
  for (const Push& push : all) sums.add(0, -push.impulse, push.arm);
  EXPECT_EQ(sums.impulse(0), Vec3(Vec3::Zero()));
  EXPECT_EQ(sums.angular_impulse(0), Vec3(Vec3::Zero()));
}

TEST(ContactImpulses, SurviveAsWords) {
  ContactImpulses sums(2, 2.5, 0.3), copy(2, 2.5, 0.3);
  for (const Push& push : pushes(10)) sums.add(0, push.impulse, push.arm);
  sums.add(1, Vec3(-1e-9, 1e9, -3.0), Vec3::UnitX());
  copy.set_words(sums.words());
  EXPECT_EQ(copy.words(), sums.words());
  EXPECT_EQ(copy.impulse(1), sums.impulse(1));
  EXPECT_LT(copy.impulse(1)[0], 0.0);
}

TEST(ContactImpulses, LeaveOutWhatIsNotFinite) {
  ContactImpulses sums(1, 1.0, 1.0);
  sums.add(0, Vec3(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 2.0), Vec3::Zero());
  EXPECT_EQ(sums.impulse(0), Vec3(0.0, 0.0, 2.0));
}

}  // namespace
}  // namespace bulkley::contact_impulse_test
