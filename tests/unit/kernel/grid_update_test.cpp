#include "kernel/grid_update.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace bulkley::grid_update_test {
namespace {

const Vec3 gravity(0.5, 0.0, -9.81);

TEST(GridUpdate, MomentumBecomesVelocityUnderGravity) {
  std::vector<Node> nodes = {{{2.0, -4.0, 6.0, 2.0}}};
  const std::vector<LocalIndex> active = {0};
  grid_update({gravity, 0.1, 1e-12}, active, nodes.data(), nullptr);
  EXPECT_DOUBLE_EQ(nodes[0].c[0], 1.0 + 0.05);
  EXPECT_DOUBLE_EQ(nodes[0].c[1], -2.0);
  EXPECT_DOUBLE_EQ(nodes[0].c[2], 3.0 - 0.981);
  EXPECT_EQ(nodes[0].c[3], 2.0);
}

TEST(GridUpdate, TheImpulseBecomesTheChangeOfVelocity) {
  std::vector<Node> nodes = {{{2.0, -4.0, 6.0, 2.0}}}, impulse = {{{0.4, 0.2, 0.0, 0.0}}};
  const std::vector<LocalIndex> active = {0};
  grid_update({gravity, 0.1, 1e-12}, active, nodes.data(), impulse.data());
  const double change[3] = {0.2 + 0.05, 0.1, -0.981}, before[3] = {1.0, -2.0, 3.0};
  for (int a = 0; a < 3; ++a) {
    EXPECT_DOUBLE_EQ(impulse[0].c[a], change[a]);
    EXPECT_DOUBLE_EQ(nodes[0].c[a], before[a] + change[a]);
  }
}

TEST(Images, AreTheSumOverTheParticlesAndTheirMirrorImages) {
  // By hand: what was behind a wall is mirrored in the wall's frame, falls with its image, and its mass is added.
  const Vec3 sign(-1.0, 1.0, -1.0), wall(0.25, 0.0, 0.5);
  const double dt = 0.1;
  for (const bool split : {false, true}) {
    std::vector<Node> nodes = {{{0.5, 0.25, -1.0, 0.5}}, {{4.0, 2.0, 6.0, 2.0}}};
    std::vector<Node> impulse = {{{0.125, -0.5, 0.25, 0.0}}, {{1.0, -2.0, 3.0, 0.0}}};
    if (!split)
      for (int n = 0; n < 2; ++n)
        for (int a = 0; a < 3; ++a) nodes[n].c[a] += impulse[n].c[a];
    const std::vector<NodeImage> images = {{0, 1, sign, wall}};
    const GridUpdate update{gravity, dt, 1e-12};
    Node* change = split ? impulse.data() : nullptr;
    const double p[2][3] = {{0.5, 0.25, -1.0}, {4.0, 2.0, 6.0}}, f[2][3] = {{0.125, -0.5, 0.25}, {1.0, -2.0, 3.0}};
    fold_images(update, images, nodes.data(), change);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(nodes[0].c[c], 0.0);
    EXPECT_EQ(nodes[1].c[3], 2.5);
    const std::vector<LocalIndex> active = {0, 1};
    grid_update(update, active, nodes.data(), change);
    unfold_images(images, nodes.data(), change);
    for (int a = 0; a < 3; ++a) {
      const double before = (p[1][a] + sign[a] * (p[0][a] - 0.5 * wall[a]) + 0.5 * wall[a]) / 2.5;
      const double force = f[1][a] + sign[a] * f[0][a] + dt * gravity[a] * (2.0 + sign[a] * 0.5);
      EXPECT_NEAR(nodes[1].c[a], before + force / 2.5, 1e-15);
      EXPECT_NEAR(nodes[0].c[a] - wall[a], sign[a] * (nodes[1].c[a] - wall[a]), 1e-15);
      if (split) {
        EXPECT_NEAR(impulse[1].c[a], force / 2.5, 1e-15);
        EXPECT_NEAR(impulse[0].c[a], sign[a] * force / 2.5, 1e-15);
      }
    }
  }
}

TEST(GridUpdate, EmptyNodesGetNoVelocity) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double mass : {0.0, 1e-13, 1e-12, nan}) {  // up to the limit itself
    std::vector<Node> nodes = {{{1e-13, 1.0, 2.0, mass}}}, impulse = {{{1.0, 1.0, 1.0, 0.0}}};
    const std::vector<LocalIndex> active = {0};
    grid_update({gravity, 0.1, 1e-12}, active, nodes.data(), impulse.data());
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(nodes[0].c[a], 0.0) << mass;
      EXPECT_EQ(impulse[0].c[a], 0.0) << mass;
    }
  }
  std::vector<Node> nodes = {{{0.0, 0.0, 0.0, 1.1e-12}}};
  const std::vector<LocalIndex> active = {0};
  grid_update({gravity, 0.1, 1e-12}, active, nodes.data(), nullptr);
  EXPECT_DOUBLE_EQ(nodes[0].c[2], -0.981);
}

TEST(GridUpdate, OnlyActiveNodesAreTouched) {
  std::vector<Node> nodes(3, {{1.0, 2.0, 3.0, 4.0}}), impulse(nodes);
  const std::vector<LocalIndex> active = {1};
  grid_update({gravity, 0.1, 1e-12}, active, nodes.data(), impulse.data());
  for (const std::size_t n : {0u, 2u})
    for (int c = 0; c < 4; ++c) {
      EXPECT_EQ(nodes[n].c[c], c + 1.0);
      EXPECT_EQ(impulse[n].c[c], c + 1.0);
    }
  EXPECT_NE(nodes[1].c[0], 1.0);
}

TEST(GridUpdate, ConstraintsChangeVelocityAndChangeAlike) {
  const std::vector<NodeConstraint> constraints = {{1, Contact::slip, 0.0, Vec3::UnitZ()},
                                                   {2, Contact::sticky, 0.0, Vec3::UnitX()}};
  std::vector<Node> nodes(3, {{1.0, 2.0, 3.0, 4.0}}), change(3, {{0.5, 0.25, 0.125, 7.0}});
  ContactImpulses impulses;
  apply_constraints(constraints, nodes.data(), change.data(), impulses);
  const double v[3][4] = {{1, 2, 3, 4}, {1, 2, 0, 4}, {0, 0, 0, 4}};
  const double dv[3][4] = {{0.5, 0.25, 0.125, 7}, {0.5, 0.25, -2.875, 7}, {-0.5, -1.75, -2.875, 7}};
  for (std::size_t n = 0; n < 3; ++n)
    for (int c = 0; c < 4; ++c) {
      EXPECT_EQ(nodes[n].c[c], v[n][c]);
      EXPECT_EQ(change[n].c[c], dv[n][c]);
    }
  apply_constraints(constraints, nodes.data(), nullptr, impulses);
  EXPECT_EQ(nodes[2].c[0], 0.0);
}

// The order of the list counts: friction of the first contact sees the velocity before the second.
TEST(GridUpdate, ConstraintsOfANodeActInTheirOrder) {
  const NodeConstraint floor{0, Contact::separating, 0.5, Vec3::UnitZ()}, wall{0, Contact::slip, 0.0, Vec3::UnitX()};
  std::vector<Node> one = {{{4.0, 3.0, -2.0, 1.0}}}, two = one;
  ContactImpulses impulses;
  apply_constraints(std::vector{floor, wall}, one.data(), nullptr, impulses);
  apply_constraints(std::vector{wall, floor}, two.data(), nullptr, impulses);
  EXPECT_DOUBLE_EQ(one[0].c[1], 3.0 * (1.0 - 1.0 / 5.0));
  EXPECT_DOUBLE_EQ(two[0].c[1], 3.0 * (1.0 - 1.0 / 3.0));
}

}  // namespace
}  // namespace bulkley::grid_update_test
