// Predictions of the steps that an impact takes.
#include "stepping/impact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace bulkley::impact_test {
namespace {

constexpr double dx = 0.0125;  // m
constexpr double end = 0.2;    // s

TimeStepSettings settings() {
  TimeStepSettings s;
  s.integrator = IntegratorKind::imex;
  return s;
}

TEST(Impact, ShearsFromContactOnAndLessAsTheSheetThins) {
  const Impact ball{0.01, 5.0, 0.2, 2};
  EXPECT_EQ(largest_gradient(ball, dx, 0.0099), 0.0);
  const double first = largest_gradient(ball, dx, 0.01);
  EXPECT_NEAR(first, 1.5 * 5.0 / dx, 1e-9);
  EXPECT_NEAR(largest_gradient(ball, dx, 0.01 + 0.2 / 5.0), first / 4.0, 1e-9);  // it runs L in L / U
  Impact plane = ball;
  plane.n_directions = 1;
  EXPECT_NEAR(largest_gradient(plane, dx, 0.01 + 0.2 / 5.0), first / 2.0, 1e-9);
}

TEST(Impact, AddsTheStepsOfItsDeformation) {
  const double smooth = 0.00125;  // s
  EXPECT_EQ(count_steps(settings(), dx, end, smooth, {}), 160.0);
  // Too late, and one whose shear never shortens a step.
  EXPECT_EQ(count_steps(settings(), dx, end, smooth, {{0.3, 5.0, 0.2, 2}}), 160.0);
  EXPECT_EQ(count_steps(settings(), dx, end, smooth, {{0.0, 0.1, 0.2, 2}}), 160.0);
  // By hand: dt = 0.08 / ||L|| while it is below `smooth`, until 1 + t U / L = x.
  const double fastest = 1.5 * 5.0 / dx / 0.08, x = std::sqrt(fastest * smooth), last = (x - 1.0) * 0.04;
  EXPECT_NEAR(count_steps(settings(), dx, end, smooth, {{0.0, 5.0, 0.2, 2}}),
              fastest * 0.04 * (1.0 - 1.0 / x) + (end - last) / smooth, 2.0);
  const double plane = std::min(end, (fastest * smooth - 1.0) * 0.04);
  EXPECT_NEAR(count_steps(settings(), dx, end, smooth, {{0.0, 5.0, 0.2, 1}}),
              fastest * 0.04 * std::log1p(plane / 0.04) + (end - plane) / smooth, 2.0);
}

TEST(Impact, FollowsTheDeformationLimitAndTheCells) {
  TimeStepSettings half = settings();
  half.deformation_limit = 0.05;
  const std::vector<Impact> impacts{{0.0, 5.0, 0.2, 2}};
  constexpr double never = 1.0;  // s
  const double n = count_steps(settings(), dx, end, never, impacts);
  EXPECT_NEAR(count_steps(half, dx, end, never, impacts), 2.0 * n, 2.0);
  EXPECT_NEAR(count_steps(settings(), 0.5 * dx, end, never, impacts), 2.0 * n, 2.0);
}

TEST(Impact, BoxesMeetWhereTheyOverlapAlongAllAxes) {
  const Vec3 zero = Vec3::Zero(), one = Vec3::Ones(), down(0.0, 0.0, -2.0);
  constexpr double endless = std::numeric_limits<double>::infinity();
  const auto floor_at = [&](double z) {
    return first_contact(zero, one, down, Vec3(-endless, -endless, -endless), Vec3(endless, endless, z));
  };
  EXPECT_EQ(floor_at(-3.0), 1.5);
  EXPECT_EQ(floor_at(0.5), 0.0);  // it is there already
  EXPECT_EQ(first_contact(zero, one, down, Vec3(2.0, 0.0, -3.0), Vec3(3.0, 1.0, -2.0)), std::nullopt);  // beside
  EXPECT_EQ(first_contact(zero, one, -down, zero - 3.0 * one, zero - 2.0 * one), std::nullopt);         // behind
  EXPECT_EQ(first_contact(zero, one, Vec3(1.0, 0.0, -1.0), Vec3(3.0, 0.0, -5.0), Vec3(4.0, 1.0, -1.5)), 2.0);
  EXPECT_EQ(first_contact(zero, one, Vec3(1.0, 0.0, -1.0), Vec3(3.0, 0.0, -0.9), Vec3(4.0, 1.0, -0.8)), std::nullopt);
}

}  // namespace
}  // namespace bulkley::impact_test
