#include "grid/boundary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bulkley/base/error.hpp"

namespace bulkley::boundary_test {
namespace {

GridGeometry small_grid() {
  GridGeometry grid;
  grid.lower = Vec3(-0.3, 0.2, 0.7);
  grid.cell_size = 0.1;
  grid.n_cells = {6, 8, 5};
  return grid;
}

Faces all(FaceKind kind) {
  Faces faces;
  for (Face& face : faces) face.kind = kind;
  return faces;
}

std::vector<Int3> all_nodes(const GridGeometry& grid) {
  std::vector<Int3> nodes;
  for (int i = 0; i < grid.n_nodes(0); ++i)
    for (int j = 0; j < grid.n_nodes(1); ++j)
      for (int k = 0; k < grid.n_nodes(2); ++k) nodes.push_back({i, j, k});
  return nodes;
}

Vec3 velocity_after(const std::vector<NodeConstraint>& constraints, Vec3 v) {
  for (const NodeConstraint& c : constraints) v = constrained_velocity(c, v);
  return v;
}

// --- one contact -----------------------------------------------------------------------------------------------------

const Vec3 slanted = Vec3(1.0, 2.0, 2.0) / 3.0;
const Vec3 along = Vec3(2.0, 1.0, -2.0) / 3.0;  // at right angles to it

TEST(Contact, StickyStops) {
  EXPECT_EQ(constrained_velocity({0, Contact::sticky, 0.0, slanted}, {1.0, -2.0, 3.0}), Vec3(Vec3::Zero()));
}

TEST(Contact, StickyMovesWithTheWall) {
  const Vec3 wall = 0.7 * along;
  EXPECT_EQ(constrained_velocity({0, Contact::sticky, 0.0, slanted, wall}, {1.0, -2.0, 3.0}), wall);
}

TEST(Contact, SlipTakesTheNormalVelocityInBothDirections) {
  const NodeConstraint slip{0, Contact::slip, 0.0, slanted};
  for (const double normal_speed : {-2.0, 0.0, 2.0})
    EXPECT_LE((constrained_velocity(slip, 3.0 * along + normal_speed * slanted) - 3.0 * along).norm(), 1e-15);
}

TEST(Contact, SeparatingLetsGo) {
  const NodeConstraint wall{0, Contact::separating, 0.3, slanted};
  const Vec3 leaving = 3.0 * along + 0.5 * slanted;
  EXPECT_EQ(constrained_velocity(wall, leaving), leaving);  // to the bit
  const NodeConstraint smooth{0, Contact::separating, 0.0, slanted};
  EXPECT_LE((constrained_velocity(smooth, 3.0 * along - 2.0 * slanted) - 3.0 * along).norm(), 1e-15);
}

TEST(Contact, CoulombFrictionStaysOnItsCone) {
  const NodeConstraint wall{0, Contact::separating, 0.4, slanted};
  // Sliding: the tangential speed drops by friction x normal speed.
  EXPECT_LE((constrained_velocity(wall, 3.0 * along - 2.0 * slanted) - (3.0 - 0.4 * 2.0) * along).norm(), 1e-15);
  // Inside the cone: sticks.
  EXPECT_EQ(constrained_velocity(wall, 0.79 * along - 2.0 * slanted), Vec3(Vec3::Zero()));
  EXPECT_GT(constrained_velocity(wall, 0.81 * along - 2.0 * slanted).norm(), 0.009);
  EXPECT_EQ(constrained_velocity(wall, -2.0 * slanted), Vec3(Vec3::Zero()));
}

TEST(Contact, FrictionOnAnInclineGivesTheAnalyticAcceleration) {
  // Gravity in small increments on a body that rests on a slope: g (sin - mu cos), or rest when mu > tan.
  const double slope = 24.0 * 3.14159265358979323846 / 180.0, g = 9.81, dt = 1e-4;
  const Vec3 pull = g * dt * Vec3(std::sin(slope), 0.0, -std::cos(slope));
  for (const double friction : {0.0, std::tan(15.0 / 24.0 * slope), 1.1 * std::tan(slope)}) {
    const NodeConstraint wall{0, Contact::separating, friction, Vec3::UnitZ()};
    Vec3 v = Vec3::Zero();
    for (int step = 0; step < 1000; ++step) v = constrained_velocity(wall, v + pull);
    const double acceleration = std::max(0.0, g * (std::sin(slope) - friction * std::cos(slope)));
    EXPECT_NEAR(v.x(), acceleration * 0.1, 1e-12);
    EXPECT_NEAR(v.z(), 0.0, 1e-15);
  }
}

// --- faces -----------------------------------------------------------------------------------------------------------

TEST(Boundary, NodesOnAndOutsideAFaceAreItsNodes) {
  const GridGeometry grid = small_grid();
  const std::vector<Int3> nodes = all_nodes(grid);
  for (int f = 0; f < 6; ++f) {
    Faces faces = all(FaceKind::open);
    faces[static_cast<std::size_t>(f)] = {FaceKind::separating, 0.25};
    const auto constraints = node_constraints(grid, faces, {}, nodes);
    const int axis = f / 2;
    std::vector<bool> constrained(nodes.size(), false);
    for (const NodeConstraint& c : constraints) {
      constrained[static_cast<std::size_t>(c.node)] = true;
      EXPECT_EQ(c.contact, Contact::separating);
      EXPECT_EQ(c.friction, 0.25);
      EXPECT_EQ(c.normal, Vec3((f % 2 == 0 ? 1.0 : -1.0) * Vec3::Unit(axis)));
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const double x = grid.node_coordinate(axis, nodes[n][static_cast<std::size_t>(axis)]);
      const double half = 0.5 * grid.cell_size;
      const bool expected = f % 2 == 0 ? x < grid.lower[axis] + half : x > grid.upper()[axis] - half;
      EXPECT_EQ(constrained[n], expected);
    }
  }
}

TEST(Boundary, OpenOutflowAndPeriodicFacesConstrainNothing) {
  GridGeometry grid = small_grid();
  EXPECT_TRUE(node_constraints(grid, all(FaceKind::open), {}, all_nodes(grid)).empty());
  EXPECT_TRUE(node_constraints(grid, all(FaceKind::outflow), {}, all_nodes(grid)).empty());
  grid.n_cells = {4, 8, 4};
  grid.periodic = {true, true, true};
  EXPECT_TRUE(node_constraints(grid, all(FaceKind::periodic), {}, all_nodes(grid)).empty());
}

TEST(Boundary, ImagesAreOneCellBehindAndInFrontOfStickyAndSlipFaces) {
  const GridGeometry grid = small_grid();
  const std::vector<Int3> nodes = all_nodes(grid);
  const Vec3 wall_velocity[3] = {{0.0, 1.0, 2.0}, {3.0, 0.0, -1.0}, {-2.0, 5.0, 0.0}};
  for (int f = 0; f < 6; ++f)
    for (const FaceKind kind : {FaceKind::sticky, FaceKind::slip}) {
      Faces faces = all(FaceKind::open);
      faces[static_cast<std::size_t>(f)].kind = kind;
      if (kind == FaceKind::sticky) faces[static_cast<std::size_t>(f)].velocity = wall_velocity[f / 2];
      const std::vector<NodeImage> images = node_images(grid, faces, nodes);
      const int axis = f / 2;
      EXPECT_EQ(images.size(), nodes.size() / static_cast<std::size_t>(grid.n_nodes(axis)));
      const double wall = f % 2 == 0 ? grid.lower[axis] : grid.upper()[axis];
      for (const NodeImage& image : images) {
        Vec3 x[2];
        for (int a = 0; a < 3; ++a) {
          x[0][a] = grid.node_coordinate(a, nodes[static_cast<std::size_t>(image.behind)][static_cast<std::size_t>(a)]);
          x[1][a] = grid.node_coordinate(a, nodes[static_cast<std::size_t>(image.front)][static_cast<std::size_t>(a)]);
        }
        EXPECT_LE((0.5 * (x[0] + x[1]) - (x[0] + (wall - x[0][axis]) * Vec3::Unit(axis))).norm(), 1e-15);
        EXPECT_NEAR(x[1][axis] - wall, (f % 2 == 0 ? 1.0 : -1.0) * grid.cell_size, 1e-15);
        EXPECT_EQ(image.sign[axis], -1.0);
        EXPECT_EQ(image.sign[(axis + 1) % 3], kind == FaceKind::sticky ? -1.0 : 1.0);
        EXPECT_EQ(image.velocity, faces[static_cast<std::size_t>(f)].velocity);
      }
    }
}

TEST(Boundary, OtherFacesAndLoneNodesHaveNoImages) {
  const GridGeometry grid = small_grid();
  for (const FaceKind kind : {FaceKind::separating, FaceKind::open, FaceKind::outflow})
    EXPECT_TRUE(node_images(grid, all(kind), all_nodes(grid)).empty());
  EXPECT_TRUE(node_images(grid, all(FaceKind::slip), {{0, 3, 3}, {1, 3, 3}, {3, 3, 3}}).empty());
  EXPECT_EQ(node_images(grid, all(FaceKind::slip), {{0, 3, 3}, {1, 3, 3}, {2, 3, 3}}).size(), 1u);
}

TEST(Boundary, AFaceMovesAlongItselfOnly) {
  Faces faces = all(FaceKind::sticky);
  faces[2].velocity = {1.0, 1e-9, 0.0};
  EXPECT_THROW(node_constraints(small_grid(), faces, {}, {}), UsageError);
  EXPECT_THROW(node_images(small_grid(), faces, {}), UsageError);
}

TEST(Boundary, CornersOfSlipFacesHoldEveryDirection) {
  const GridGeometry grid = small_grid();
  const Int3 edge{1, 1, 4}, corner{0, 0, 0}, inside{2, 2, 3};
  const Vec3 v(1.0, -2.0, 3.0);
  EXPECT_EQ(velocity_after(node_constraints(grid, all(FaceKind::slip), {}, {edge}), v), Vec3(0.0, 0.0, 3.0));
  EXPECT_EQ(velocity_after(node_constraints(grid, all(FaceKind::slip), {}, {corner}), v), Vec3(Vec3::Zero()));
  EXPECT_EQ(velocity_after(node_constraints(grid, all(FaceKind::slip), {}, {inside}), v), v);
}

TEST(Boundary, ANodeUnderSeveralConstraintsHasThemTwiceInOrder) {
  const GridGeometry grid = small_grid();
  Faces faces = all(FaceKind::open);
  faces[0].kind = FaceKind::slip;
  faces[4].kind = FaceKind::sticky;
  const Collider ball{"ball", {Sphere{{-0.3, 0.5, 0.7}, 0.15}}, Contact::separating, 0.5};
  const auto one = node_constraints(grid, faces, {}, {{1, 4, 3}});
  ASSERT_EQ(one.size(), 1u);
  const auto several = node_constraints(grid, faces, {ball}, {{5, 5, 5}, {1, 4, 1}});
  ASSERT_EQ(several.size(), 6u);
  const Contact expected[] = {Contact::slip, Contact::sticky, Contact::separating};
  for (std::size_t n = 0; n < 6; ++n) {
    EXPECT_EQ(several[n].node, 1);
    EXPECT_EQ(several[n].contact, expected[n % 3]);
  }
}

TEST(Boundary, TwoSeparatingWallsInARightAngleStopBothNormals) {
  const GridGeometry grid = small_grid();
  Faces faces = all(FaceKind::open);
  faces[0] = faces[2] = {FaceKind::separating, 0.2};
  const auto corner = node_constraints(grid, faces, {}, {{1, 1, 4}});
  const Vec3 pressed = velocity_after(corner, {-1.0, -2.0, 5.0});
  EXPECT_NEAR(pressed.x(), 0.0, 1e-15);
  EXPECT_NEAR(pressed.y(), 0.0, 1e-15);
  EXPECT_GT(pressed.z(), 4.0);
  const Vec3 lifted = velocity_after(corner, {1.0, 2.0, 5.0});
  EXPECT_EQ(lifted, Vec3(1.0, 2.0, 5.0));
}

// --- colliders -------------------------------------------------------------------------------------------------------

TEST(Boundary, ColliderHoldsTheNearestNodesAlongItsNormals) {
  const GridGeometry grid = small_grid();
  const Vec3 center(0.0, 0.55, 0.95);
  const std::vector<Int3> nodes = all_nodes(grid);
  std::vector<std::size_t> held;
  for (const Contact contact : {Contact::separating, Contact::slip, Contact::sticky}) {
    const Collider ball{"ball", {Sphere{center, 0.17}}, contact, 0.0};
    const double reach = contact == Contact::separating ? 0.17 : 0.17 + 0.75 * grid.cell_size;
    const auto constraints = node_constraints(grid, all(FaceKind::open), {ball}, nodes);
    held.push_back(constraints.size());
    std::size_t within = 0;
    for (const Int3& n : nodes) {
      const Vec3 x(grid.node_coordinate(0, n[0]), grid.node_coordinate(1, n[1]), grid.node_coordinate(2, n[2]));
      within += (x - center).norm() <= reach ? 1 : 0;
    }
    EXPECT_EQ(constraints.size(), within);
    for (const NodeConstraint& c : constraints) {
      const Int3& n = nodes[static_cast<std::size_t>(c.node)];
      const Vec3 x(grid.node_coordinate(0, n[0]), grid.node_coordinate(1, n[1]), grid.node_coordinate(2, n[2]));
      EXPECT_LE((c.normal - (x - center).normalized()).norm(), 1e-12);
    }
  }
  ASSERT_GT(held[0], 10u);
  EXPECT_GT(held[1], held[0] + 10);
  EXPECT_EQ(held[1], held[2]);
}

TEST(Boundary, FaultsOfFacesNameTheFaceAndTheKey) {
  Faces faces = all(FaceKind::sticky);
  EXPECT_TRUE(face_faults(faces).empty());
  faces[3].kind = FaceKind::periodic;
  faces[0].velocity = {0.1, 0.0, 0.0};
  faces[5].friction = -0.1;
  faces[1].velocity = {0.0, NAN, 0.0};
  const std::vector<FaceFault> faults = face_faults(faces);
  ASSERT_EQ(faults.size(), 4u);
  const std::pair<std::size_t, std::string> expected[] = {{3, ""}, {0, "velocity"}, {1, "velocity"}, {5, "friction"}};
  for (std::size_t f = 0; f < 4; ++f) EXPECT_EQ(std::pair(faults[f].face, std::string(faults[f].key)), expected[f]) << f;
  EXPECT_EQ(faults[0].sentence, "is periodic but 'y_lower' is not; an axis is periodic at both ends or at none");
}

TEST(Boundary, BadWallsAreUsageErrors) {
  GridGeometry grid = small_grid();
  const auto attempt = [&](const Faces& faces, const std::vector<Collider>& colliders) {
    return node_constraints(grid, faces, colliders, {});
  };
  Faces faces = all(FaceKind::slip);
  EXPECT_NO_THROW(attempt(faces, {}));
  faces[3].friction = -0.1;
  EXPECT_THROW(attempt(faces, {}), UsageError);
  EXPECT_THROW(attempt(all(FaceKind::periodic), {}), UsageError);
  EXPECT_THROW(attempt(all(FaceKind::slip), {{"rod", {Sphere{{0, 0, 0}, -1.0}}, Contact::slip, 0.0}}), UsageError);
  EXPECT_THROW(attempt(all(FaceKind::slip), {{"rod", {Sphere{{0, 0, 0}, 1.0}}, Contact::separating, NAN}}), UsageError);
  grid.periodic[1] = true;
  EXPECT_THROW(attempt(all(FaceKind::slip), {}), UsageError);
}

// --- moving colliders ------------------------------------------------------------------------------------------------

std::vector<LocalIndex> own_places(const std::vector<Int3>& nodes) {
  std::vector<LocalIndex> places(nodes.size());
  std::iota(places.begin(), places.end(), 0);
  return places;
}

TEST(Contact, SlipAndSeparatingAreRelativeToTheWall) {
  const Vec3 wall = 0.5 * slanted + 0.2 * along;
  const Vec3 coming = wall + 3.0 * along - 2.0 * slanted;
  EXPECT_LE((constrained_velocity({0, Contact::slip, 0.0, slanted, wall}, coming) - wall - 3.0 * along).norm(), 1e-15);
  const NodeConstraint rough{0, Contact::separating, 0.4, slanted, wall};
  EXPECT_LE((constrained_velocity(rough, coming) - wall - (3.0 - 0.8) * along).norm(), 1e-15);
  EXPECT_EQ(constrained_velocity(rough, wall - 2.0 * slanted), wall) << "sticks";
  const Vec3 leaving = wall + 0.1 * slanted;
  EXPECT_EQ(constrained_velocity(rough, leaving), leaving);
  EXPECT_NE(constrained_velocity(rough, 0.4 * slanted), 0.4 * slanted) << "slower than the wall that follows it";
}

TEST(MovingCollider, HoldsTheNodesWhereItIsWithItsOwnVelocity) {
  const GridGeometry grid = small_grid();
  const std::vector<Int3> nodes = all_nodes(grid);
  for (const Contact contact : {Contact::sticky, Contact::slip, Contact::separating}) {
    Collider block{"block", {Box{{-0.1, 0.4, 0.8}, {0.1, 0.6, 1.0}}}, contact, 0.0, {}};
    block.motion.center = Vec3(0.0, 0.5, 0.9);
    block.motion.velocity = Vec3(0.0, 0.2, 0.0);
    block.motion.angular_velocity = Vec3(0.0, 0.0, 3.0);
    EXPECT_TRUE(node_constraints(grid, all(FaceKind::open), {block}, nodes).empty()) << "it is not fixed";
    MovingConstraints moving(grid, {block}, nodes, own_places(nodes), {});
    const double time = 0.37, dt = 0.01;
    const Pose pose = block.motion.pose(time);
    std::vector<int> held(nodes.size(), 0);
    for (const NodeConstraint& c : moving.at(time, dt)) {
      const auto n = static_cast<std::size_t>(c.node);
      ++held[n];
      const Vec3 x = grid.node_position(nodes[n]);
      EXPECT_EQ(c.collider, 0);
      EXPECT_LE((c.velocity - block.motion.velocity_at(time + 0.5 * dt).at(x)).norm(), 1e-15);
      EXPECT_LE((c.arm - (x - Vec3(0.0, 0.5 + 0.2 * time, 0.9))).norm(), 1e-15);
      EXPECT_LE((c.normal - outward_normal(block.shape, pose, x)).norm(), 1e-15);
    }
    const double reach = contact == Contact::separating ? 0.0 : 0.75 * grid.cell_size;
    int n_held = 0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      EXPECT_EQ(held[n], signed_distance(block.shape, pose, grid.node_position(nodes[n])) <= reach ? 1 : 0);
      n_held += held[n];
    }
    EXPECT_GT(n_held, 5);
  }
}

TEST(MovingCollider, BesideFixedWallsAllCountTwice) {
  const GridGeometry grid = small_grid();
  const std::vector<Int3> nodes = all_nodes(grid);
  Faces faces = all(FaceKind::open);
  faces[0] = {FaceKind::separating, 0.0};
  faces[2] = {FaceKind::separating, 0.0};
  Collider fixed{"fixed", {Sphere{{-0.3, 0.2, 0.9}, 0.11}}, Contact::slip, 0.0, {}};
  Collider ball{"ball", {Sphere{{-0.3, 0.2, 0.7}, 0.25}}, Contact::separating, 0.0, {}};
  ball.motion.velocity = Vec3(0.0, 0.0, 0.2);
  const std::vector<Collider> colliders{ball, fixed};
  const std::vector<NodeConstraint> walls = node_constraints(grid, faces, colliders, nodes);
  std::vector<LocalIndex> places = own_places(nodes);
  for (LocalIndex& place : places) place = 1000 - place;
  MovingConstraints moving(grid, colliders, nodes, places, walls);
  std::vector<std::vector<int>> sequence(nodes.size());
  for (const NodeConstraint& c : walls) sequence[static_cast<std::size_t>(c.node)].push_back(c.collider);
  for (const NodeConstraint& c : moving.at(0.0, 0.1))
    sequence[static_cast<std::size_t>(1000 - c.node)].push_back(c.collider);
  const auto at = [&](const Int3& node) {
    return sequence[static_cast<std::size_t>(std::find(nodes.begin(), nodes.end(), node) - nodes.begin())];
  };
  EXPECT_EQ(at({3, 3, 1}), (std::vector<int>{})) << "nothing near";
  EXPECT_EQ(at({3, 1, 1}), (std::vector<int>{-1, 0, -1, 0})) << "one face, the ball";
  EXPECT_EQ(at({2, 2, 1}), (std::vector<int>{0})) << "the ball alone";
  EXPECT_EQ(at({1, 1, 1}), (std::vector<int>{-1, -1, -1, -1, 0, -1, -1, 0})) << "two faces, the ball";
  EXPECT_EQ(at({1, 1, 3}), (std::vector<int>{-1, -1, 1, -1, -1, 1, 0, -1, -1, 1, 0})) << "two faces, both colliders";
}

TEST(MovingCollider, SpeedIsThatOfItsFarthestPoint) {
  const GridGeometry grid = small_grid();
  Collider rod{"rod", {Capsule{{0.0, 0.5, 0.9}, {0.2, 0.5, 0.9}, 0.05}}, Contact::sticky, 0.0, {}};
  EXPECT_EQ(collider_speed(grid, {rod}, 0.0, 1.0), 0.0);
  rod.motion.center = Vec3(0.0, 0.5, 0.9);
  rod.motion.angular_velocity = Vec3(0.0, 2.0, 0.0);
  const double tip = 0.25;
  EXPECT_GE(collider_speed(grid, {rod}, 0.0, 1.0), 2.0 * tip);
  EXPECT_LE(collider_speed(grid, {rod}, 0.0, 1.0), 2.0 * std::hypot(tip, std::hypot(0.05, 0.05)) * (1.0 + 1e-12));
  Collider drum{"drum", {Complement{{{Shape{Sphere{{0.0, 0.6, 0.9}, 0.2}}}}}}, Contact::sticky, 0.0, {}};
  drum.motion = rod.motion;
  const double bound = collider_speed(grid, {drum}, 0.0, 1.0);  // as far as the domain goes
  EXPECT_GE(bound, 2.0 * 0.5);
  EXPECT_LE(bound, 2.0 * 1.0);
}

}  // namespace
}  // namespace bulkley::boundary_test
