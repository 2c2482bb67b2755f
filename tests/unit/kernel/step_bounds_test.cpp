// The groups of StepBounds: how each member merges, and that none is left out.
#include "kernel/step_bounds.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

namespace bulkley::step_bounds_test {
namespace {

// Distinct numbers in every member, from `seed`.
StepBounds numbered(int seed) {
  StepBounds bounds;
  int k = 0;
  StepBounds::each_group(
      [&](const char*, auto& group) {
        std::remove_cvref_t<decltype(group)>::each(
            [&](const char*, auto& member) {
              const int number = 1 + (seed * 37 + 11 * ++k) % 101;
              member.value = static_cast<decltype(member.value)>(number);
              if constexpr (requires { member.id; }) member.id = number % 7;
            },
            group);
      },
      bounds);
  return bounds;
}

// Every number of the bounds by "group.member".
std::map<std::string, double> numbers(const StepBounds& bounds) {
  std::map<std::string, double> result;
  StepBounds::each_group(
      [&](const char* group_name, const auto& group) {
        std::remove_cvref_t<decltype(group)>::each(
            [&](const char* name, const auto& member) {
              const std::string key = fmt::format("{}.{}", group_name, name);
              EXPECT_FALSE(result.contains(key)) << key << " is listed twice";
              result[key] = static_cast<double>(member.value);
              if constexpr (requires { member.id; }) result[key + ".id"] = static_cast<double>(member.id);
            },
            group);
      },
      bounds);
  return result;
}

TEST(StepBounds, EveryMemberMergesByItsRule) {
  const StepBounds a = numbered(1), b = numbered(2);
  StepBounds merged = a;
  merged.merge(b);
  const auto of_a = numbers(a), of_b = numbers(b), of_merged = numbers(merged);
  const std::set<std::string> totals = {"totals.n_particles",        "transport.n_removed", "transport.n_migrated",
                                        "failures.n_not_finite",     "failures.n_inverted", "failures.n_escaped",
                                        "failures.n_undefined_nodes"};
  const std::set<std::string> smallest = {"totals.smallest_volume_ratio", "failures.failed_id", "failures.undefined_node"};
  EXPECT_EQ(of_merged.size(), 4u * 2 + 4 + 3 + 3 + 6 + 3);
  for (const auto& [name, value] : of_merged) {
    const double x = of_a.at(name), y = of_b.at(name);
    if (name.ends_with(".id"))
      EXPECT_EQ(value, of_a.at(name.substr(0, name.size() - 3)) > of_b.at(name.substr(0, name.size() - 3)) ? x : y) << name;
    else
      EXPECT_EQ(value, totals.contains(name) ? x + y : smallest.contains(name) ? std::min(x, y) : std::max(x, y)) << name;
  }
}

TEST(StepBounds, NothingIsNeutral) {
  const StepBounds a = numbered(3);
  StepBounds left = a, right;
  left.merge(StepBounds{});
  right.merge(a);
  EXPECT_EQ(numbers(left), numbers(a));
  EXPECT_EQ(numbers(right), numbers(a));
}

TEST(StepBounds, OrderDoesNotMatterAndTheSmallestIdWinsTies) {
  StepBounds a = numbered(4), b = numbered(5);
  a.motion.speed = {2.0, 7};
  b.motion.speed = {2.0, 3};
  StepBounds ab = a, ba = b;
  ab.merge(b);
  ba.merge(a);
  EXPECT_EQ(numbers(ab), numbers(ba));
  EXPECT_EQ(ab.motion.speed.id, 3);
}

TEST(StepBounds, FailuresOfAnyKindCount) {
  EXPECT_FALSE(StepBounds{}.failed());
  for (Total FailureCounts::*count : {&FailureCounts::n_not_finite, &FailureCounts::n_inverted, &FailureCounts::n_escaped,
                                      &FailureCounts::n_undefined_nodes}) {
    StepBounds bounds;
    ++(bounds.failures.*count);
    EXPECT_TRUE(bounds.failed());
  }
}

}  // namespace
}  // namespace bulkley::step_bounds_test
