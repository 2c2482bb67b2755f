#include "grid/rigid_collisions.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bulkley::rigid_collisions_test {
namespace {

constexpr double g = 9.81, dx = 0.05;

/// Bodies without material: gravity, collisions, motion.
struct World {
  GridGeometry grid;
  Faces faces{};
  std::vector<Collider> colliders;
  std::vector<RigidBody> bodies;
  std::vector<RigidStart> starts;
  std::vector<RigidState> states;
  Vec3 gravity{0.0, 0.0, -g};
  double time = 0.0;

  explicit World(std::vector<RigidBody> all) : bodies(std::move(all)) {
    grid.lower = Vec3::Zero();
    grid.cell_size = dx;
    grid.n_cells = {400, 40, 40};
    for (const RigidBody& body : bodies) {
      starts.push_back(start_of(body, dx));
      states.push_back(starts.back().state);
    }
  }
  double energy() const {
    double sum = 0.0;
    for (std::size_t b = 0; b < bodies.size(); ++b) sum += kinetic_energy(starts[b].mass, states[b]);
    return sum;
  }
  Vec3 velocity(std::size_t b = 0) const { return bulkley::velocity(starts[b].mass, states[b]).velocity; }
  Vec3 spin(std::size_t b = 0) const { return bulkley::velocity(starts[b].mass, states[b]).angular_velocity; }
  void run(double duration, double dt, const auto& watch) {
    RigidCollisions collisions(grid, faces, colliders, bodies, starts);
    for (const double end = time + duration; time < end - 0.5 * dt; time += dt) {
      const std::vector<RigidState> before = states;
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        states[b].momentum += dt * starts[b].mass.mass * gravity;
        if (const auto& guide = starts[b].guide)
          set_rate(starts[b].mass, *guide, rate_of(starts[b].mass, *guide, states[b]), states[b]);
      }
      const double falling = energy();
      std::vector<CollisionEffect> effects = collisions.collide(time, dt, before, states);
      for (std::size_t b = 0; b < bodies.size(); ++b) advance(starts[b].mass, starts[b].guide, dt, states[b]);
      collisions.push_out(dt, states, effects);
      double work = 0.0;
      for (const CollisionEffect& effect : effects) work += effect.work;
      EXPECT_NEAR(energy() - falling, work, 1e-12 * (1.0 + falling));
      watch();
    }
  }
  void run(double duration, double dt) {
    run(duration, dt, [] {});
  }
};

RigidBody solid(const Shape& shape) {
  RigidBody body;
  body.shape = shape;
  body.density = 1000.0;
  return body;
}
RigidBody ball(const Vec3& center, double radius = 0.2) { return solid(Shape{Sphere{center, radius}}); }
RigidBody brick(const Vec3& lower, const Vec3& upper) { return solid(Shape{Box{lower, upper}}); }

TEST(RigidCollisions, ABallBouncesToTheSquareOfItsRestitution) {
  RigidBody body = ball({1.0, 1.0, 0.7});
  body.restitution = 0.6;
  World world({body});
  bool has_hit = false;
  double highest = 0.0;
  world.run(0.7, 1e-4, [&] {
    has_hit = has_hit || world.velocity()[2] > 0.0;
    if (has_hit) highest = std::max(highest, world.states[0].center[2]);
  });
  EXPECT_NEAR(highest - 0.2, 0.36 * 0.5, 0.003);  // it is noticed up to v dt below the floor
}

TEST(RigidCollisions, ABoxAtRestStays) {
  World world({brick({0.8, 0.9, 0.0}, {1.2, 1.1, 0.1})});
  world.run(1.0, 1e-3);
  EXPECT_LT(world.velocity().norm(), 1e-9);
  EXPECT_LT(world.spin().norm(), 1e-9);
  EXPECT_NEAR(world.states[0].center[2], 0.05, 0.02 * dx);
}

TEST(RigidCollisions, WhatLiesDoesNotJump) {
  RigidBody body = brick({0.8, 0.9, 0.0}, {1.2, 1.1, 0.1});
  body.restitution = 0.9;
  World world({body});
  world.run(1e-3, 1e-3);
  world.run(0.2, 1e-3, [&] { EXPECT_LT(world.velocity().norm(), 1e-9); });
}

TEST(RigidCollisions, WhatHasComeTooDeepIsPushedOutAndGetsNoSpeed) {
  World world({ball({1.0, 1.0, 0.7})});
  double lowest = 1.0, fastest = 0.0;
  world.run(1.0, 5e-3, [&] {
    lowest = std::min(lowest, world.states[0].center[2]);
    if (lowest < 0.2) fastest = std::max(fastest, world.velocity()[2]);
  });
  EXPECT_LT(lowest, 0.2 - 0.1 * dx);
  EXPECT_LT(fastest, 1e-12);
  EXPECT_NEAR(world.states[0].center[2], 0.2 - 0.005 * dx, 0.006 * dx);
}

TEST(RigidCollisions, ABoxThatIsDroppedOnAnEdgeComesToRestOnAFace) {
  RigidBody body = brick({0.9, 0.9, 0.4}, {1.3, 1.1, 0.6});
  body.shape = Shape{Placed{std::make_shared<Shape>(body.shape), Vec3::UnitY(), 0.4, Vec3(1.1, 1.0, 0.5), Vec3::Zero()}};
  World world({body});
  world.run(3.0, 5e-4);
  EXPECT_LT(world.velocity().norm(), 1e-9);
  EXPECT_NEAR(world.states[0].center[2], 0.1, 0.02 * dx);
}

/// Acceleration down a slope of angle `angle`, gravity being turned instead of the floor.
double rolling(const RigidBody& body, double angle) {
  World world({body});
  world.gravity = g * Vec3(std::sin(angle), 0.0, -std::cos(angle));
  world.run(0.2, 1e-4);
  const double first = world.velocity()[0];
  world.run(0.8, 1e-4);
  return (world.velocity()[0] - first) / 0.8;
}

TEST(RigidCollisions, ABallRollsAndSlidesDownASlope) {
  RigidBody body = ball({1.0, 1.0, 0.2});
  body.friction = 0.3;
  EXPECT_NEAR(rolling(body, 0.02) / (5.0 / 7.0 * g * std::sin(0.02)), 1.0, 1e-3);
  EXPECT_NEAR(rolling(body, 0.3) / (5.0 / 7.0 * g * std::sin(0.3)), 1.0, 1e-3);
  const double steep = std::atan(3.5 * 0.3) + 0.05;
  EXPECT_NEAR(rolling(body, steep) / (g * (std::sin(steep) - 0.3 * std::cos(steep))), 1.0, 2e-3);
}

TEST(RigidCollisions, ACylinderAndACapsuleRollOnTheirSides) {
  const RigidBody trunk = solid(Shape{Cylinder{{1.0, 0.8, 0.2}, {1.0, 1.3, 0.2}, 0.2}});
  EXPECT_NEAR(rolling(trunk, 0.02) / (2.0 / 3.0 * g * std::sin(0.02)), 1.0, 1e-3);
  const RigidBody pill = solid(Shape{Capsule{{1.0, 0.8, 0.2}, {1.0, 1.3, 0.2}, 0.2}});
  const RigidStart start = start_of(pill, dx);
  const double moment = start.mass.moments.minCoeff();
  EXPECT_NEAR(rolling(pill, 0.02) / (g * std::sin(0.02) / (1.0 + moment / (start.mass.mass * 0.04))), 1.0, 1e-3);
}

TEST(RigidCollisions, ABoxSticksBelowTheAngleOfFriction) {
  RigidBody body = brick({0.8, 0.9, 0.0}, {1.2, 1.1, 0.1});
  body.friction = 0.5;
  EXPECT_LT(std::abs(rolling(body, std::atan(0.5) - 0.02)), 1e-9);
  const double steep = std::atan(0.5) + 0.1;
  EXPECT_NEAR(rolling(body, steep) / (g * (std::sin(steep) - 0.5 * std::cos(steep))), 1.0, 1e-6);
}

TEST(RigidCollisions, TwoBallsExchangeTheirVelocities) {
  RigidBody first = ball({0.6, 1.0, 1.0}), second = ball({1.5, 1.0, 1.0});
  first.restitution = second.restitution = 1.0;
  first.velocity = {1.0, 0.0, 0.0};
  World world({first, second});
  world.gravity = Vec3::Zero();
  world.run(0.8, 1e-3);
  EXPECT_NEAR(world.velocity(0)[0], 0.0, 1e-12);
  EXPECT_NEAR(world.velocity(1)[0], 1.0, 1e-12);
}

TEST(RigidCollisions, KeepMomentumAndAngularMomentumOfTwoBodies) {
  RigidBody first = ball({0.6, 1.1, 1.05}), second = brick({1.2, 0.8, 0.8}, {1.6, 1.2, 1.3});
  first.velocity = {1.0, 0.1, 0.0};
  first.angular_velocity = {3.0, 1.0, -2.0};
  second.mass = 5.0;
  second.density.reset();
  World world({first, second});
  world.gravity = Vec3::Zero();
  const auto momenta = [&] {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
    for (const RigidState& state : world.states) {
      linear += state.momentum;
      angular += state.angular_momentum + state.center.cross(state.momentum);
    }
    return std::pair{linear, angular};
  };
  const auto start = momenta();
  const double energy = world.energy();
  world.run(0.6, 1e-3);
  const auto end = momenta();
  EXPECT_GT(world.velocity(1)[0], 0.3);
  EXPECT_LT(world.energy(), energy);
  EXPECT_LT((end.first - start.first).norm(), 1e-12 * start.first.norm());
  EXPECT_LT((end.second - start.second).norm(), 1e-4 * start.second.norm());  // a touch has a depth: two arms
}

TEST(RigidCollisions, AStackStands) {
  World world(
      {brick({0.8, 0.8, 0.0}, {1.2, 1.2, 0.2}), brick({0.85, 0.85, 0.2}, {1.15, 1.15, 0.4}), ball({1.0, 1.0, 0.5}, 0.1)});
  world.run(1.0, 5e-4);
  for (std::size_t b = 0; b < 3; ++b) EXPECT_LT(world.velocity(b).norm(), 1e-6) << b;
  EXPECT_NEAR(world.states[2].center[2], 0.5, 0.1 * dx);
}

TEST(RigidCollisions, ABallOnAColliderThatRises) {
  World world({ball({1.0, 1.0, 0.5}, 0.2)});
  Collider table{.name = "table", .shape = Shape{Box{{0.5, 0.5, 0.1}, {1.5, 1.5, 0.3}}}};
  table.motion.velocity = {0.0, 0.0, 0.5};
  table.motion.center = {1.0, 1.0, 0.2};
  world.colliders = {table};
  world.run(0.5, 1e-3);
  EXPECT_NEAR(world.velocity()[2], 0.5, 1e-9);
}

TEST(RigidCollisions, AFloorThatMovesTakesABoxAlong) {
  World world({brick({0.8, 0.9, 0.0}, {1.2, 1.1, 0.1})});
  world.faces[4].velocity = {0.5, 0.0, 0.0};
  world.run(0.5, 1e-3);
  EXPECT_NEAR(world.velocity()[0], 0.5, 1e-9);
}

TEST(RigidCollisions, APistonOnItsLineStopsAtTheWall) {
  RigidBody body = brick({0.8, 0.9, 0.3}, {1.2, 1.1, 0.5});
  body.line = Vec3::UnitZ();
  World world({body});
  world.run(1.0, 1e-3);
  EXPECT_LT(world.velocity().norm(), 1e-9);
  EXPECT_NEAR(world.states[0].center[2], 0.1, 0.02 * dx);
}

TEST(RigidCollisions, ADoorOnItsAxisStopsAtABall) {
  RigidBody door = brick({0.5, 0.95, 0.5}, {1.3, 1.05, 1.0});
  door.axis = Vec3::UnitZ();
  door.axis_point = Vec3(0.5, 1.0, 0.5);
  door.angular_velocity = {0.0, 0.0, 1.0};
  RigidBody heavy = ball({1.1, 1.3, 0.75}, 0.15);
  heavy.density = 1e9;
  World world({door, heavy});
  world.gravity = Vec3::Zero();
  world.run(1.0, 1e-3);
  EXPECT_LT(std::abs(world.spin(0)[2]), 1e-5);
  EXPECT_GT(world.states[0].turn, 0.1);
}

TEST(RigidCollisions, OpenFacesLetBodiesPass) {
  World world({ball({1.0, 1.0, 0.4}, 0.2)});
  world.faces[4].kind = FaceKind::open;
  world.run(0.3, 1e-3);
  EXPECT_NEAR(world.velocity()[2], -0.3 * g, 1e-9);
}

}  // namespace
}  // namespace bulkley::rigid_collisions_test
