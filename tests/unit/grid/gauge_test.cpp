#include "grid/gauge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bulkley::gauge_test {
namespace {

GridGeometry grid_of(const Int3& n_cells, std::array<bool, 3> periodic = {false, false, false}) {
  return {.lower = Vec3(-0.1, 0.2, 0.3), .cell_size = 0.05, .n_cells = n_cells, .periodic = periodic};
}

Gauge box(FaceName face, const Vec3& lower, const Vec3& upper) {
  Gauge gauge;
  gauge.face = face;
  gauge.lower = lower;
  gauge.upper = upper;
  return gauge;
}

Gauge disc(FaceName face, const Vec3& center, double radius) {
  Gauge gauge;
  gauge.face = face;
  gauge.center = center;
  gauge.radius = radius;
  return gauge;
}

// What the nodes on the face have of the patch, and how many have something.
struct Total {
  double area = 0.0;
  GlobalIndex n_nodes = 0;
};
Total total(const GridGeometry& grid, const Gauge& gauge) {
  const int normal = static_cast<int>(*gauge.face) / 2;
  Total result;
  Int3 n;
  for (n[0] = 0; n[0] < grid.n_nodes(0); ++n[0])
    for (n[1] = 0; n[1] < grid.n_nodes(1); ++n[1])
      for (n[2] = 0; n[2] < grid.n_nodes(2); ++n[2]) {
        double area = grid.cell_size * grid.cell_size;
        bool on_face = n[static_cast<std::size_t>(normal)] == grid.node_offset(normal);
        for (int a = 0; a < 3; ++a) {
          const auto axis = static_cast<std::size_t>(a);
          if (a == normal || grid.periodic[axis]) continue;
          const int i = n[axis] - grid.node_offset(a);
          on_face = on_face && i >= 0 && i <= grid.n_cells[axis];
          if (i == 0 || i == grid.n_cells[axis]) area *= 0.5;
        }
        const double share = on_face ? face_share(grid, gauge, n) : 0.0;
        EXPECT_GE(share, 0.0);
        EXPECT_LE(share, 1.0);
        result.area += share * area;
        result.n_nodes += share > 0.0 ? 1 : 0;
      }
  return result;
}

TEST(Gauge, TheSharesOfAFaceAreItsArea) {
  for (const std::array<bool, 3> periodic : {std::array{false, false, false}, std::array{true, false, false}}) {
    const GridGeometry grid = grid_of({8, 4, 12}, periodic);
    Gauge all;
    for (const FaceName face : {FaceName::y_lower, FaceName::z_upper, FaceName::z_lower}) {
      all.face = face;
      const Vec3 size = grid.upper() - grid.lower;
      const double area = size[0] * (face == FaceName::y_lower ? size[2] : size[1]);
      EXPECT_NEAR(gauge_area(grid, all, {}), area, 1e-15);
      const Total shares = total(grid, all);
      EXPECT_NEAR(shares.area, area, 1e-15);
      EXPECT_EQ(shares.n_nodes, count_gauge_nodes(grid, all));
    }
  }
}

// Patches anywhere, also across the edges of the face, have the area of the part on the face.
TEST(Gauge, TheSharesOfAPatchAreItsArea) {
  for (const std::array<bool, 3> periodic : {std::array{false, false, false}, std::array{true, false, false}}) {
    const GridGeometry grid = grid_of({8, 4, 12}, periodic);
    const Vec3 lower = grid.lower, upper = grid.upper();
    const Gauge inner = box(FaceName::z_lower, Vec3(-0.013, 0.21, 0.2), Vec3(0.07, 0.333, 0.31));
    EXPECT_NEAR(gauge_area(grid, inner, {}), 0.083 * 0.123, 1e-15);
    const Gauge outer = box(FaceName::z_lower, lower - Vec3::Ones(), Vec3(0.07, 0.333, 9.0));
    EXPECT_NEAR(gauge_area(grid, outer, {}), 0.17 * 0.133, 1e-15);
    const Gauge round = disc(FaceName::z_lower, Vec3(0.11, 0.29, 0.3), 0.085);
    EXPECT_NEAR(gauge_area(grid, round, {}), std::numbers::pi * 0.085 * 0.085, 1e-15);
    const Gauge small = disc(FaceName::z_lower, Vec3(0.111, 0.291, 0.3), 0.004);
    EXPECT_NEAR(gauge_area(grid, small, {}), std::numbers::pi * 0.004 * 0.004, 1e-15);
    const Gauge half = disc(FaceName::z_upper, Vec3(0.1, 0.2, upper[2]), 0.1);
    EXPECT_NEAR(gauge_area(grid, half, {}), 0.5 * std::numbers::pi * 0.01, 1e-15);
    const Gauge quarter = disc(FaceName::z_upper, Vec3(-0.1, 0.2, upper[2]), 0.1);
    EXPECT_NEAR(gauge_area(grid, quarter, {}), 0.25 * std::numbers::pi * 0.01, 1e-15);
    const Gauge raised = disc(FaceName::z_upper, Vec3(0.1, 0.3, upper[2] - 0.03), 0.05);
    EXPECT_NEAR(gauge_area(grid, raised, {}), std::numbers::pi * 0.04 * 0.04, 1e-15);
    for (const Gauge& gauge : {inner, outer, round, small, half, quarter, raised}) {
      const Total shares = total(grid, gauge);
      EXPECT_NEAR(shares.area, gauge_area(grid, gauge, {}), 1e-15);
      EXPECT_EQ(shares.n_nodes, count_gauge_nodes(grid, gauge));
    }
  }
}

TEST(Gauge, NothingOfTheFaceIsNoArea) {
  const GridGeometry grid = grid_of({8, 4, 12});
  EXPECT_EQ(gauge_area(grid, box(FaceName::z_lower, Vec3(0, 0.2, 0.31), Vec3(0.1, 0.3, 0.4)), {}), 0.0);
  EXPECT_EQ(gauge_area(grid, box(FaceName::z_lower, Vec3(0.4, 0.2, 0.3), Vec3(0.5, 0.3, 0.4)), {}), 0.0);
  EXPECT_EQ(gauge_area(grid, disc(FaceName::z_lower, Vec3(0, 0.3, 0.41), 0.1), {}), 0.0);
  EXPECT_EQ(gauge_area(grid, disc(FaceName::z_lower, Vec3(-0.3, 0.3, 0.3), 0.1), {}), 0.0);
}

// A flat box on the face is enough.
TEST(Gauge, AFlatBoxWillDo) {
  const GridGeometry grid = grid_of({8, 4, 12});
  const double top = 0.3 + 12 * 0.05;
  EXPECT_NEAR(gauge_area(grid, box(FaceName::z_upper, Vec3(0, 0.2, top), Vec3(0.1, 0.3, top)), {}), 0.01, 1e-15);
}

// Nodes behind another face count with the nearest node in the domain.
TEST(Gauge, NodesOutsideCountWithTheNearestInside) {
  const GridGeometry grid = grid_of({8, 4, 12});
  const Gauge gauge = box(FaceName::z_lower, grid.lower, grid.lower + Vec3(0.012, 0.1, 0.0));
  EXPECT_EQ(face_share(grid, gauge, {0, 2, 1}), face_share(grid, gauge, {1, 2, 1}));
  EXPECT_GT(face_share(grid, gauge, {0, 2, 1}), 0.0);
  EXPECT_EQ(face_share(grid, gauge, {2, 2, 1}), 0.0);
}

Collider collider(const Shape& shape) {
  Collider result;
  result.name = "thing";
  result.shape = shape;
  settle_center(result);
  return result;
}

Gauge part(const std::optional<Vec3>& center, double radius) {
  Gauge gauge;
  gauge.collider_number = 0;
  gauge.center = center;
  if (center) gauge.radius = radius;
  return gauge;
}

TEST(Gauge, AreasOnColliders) {
  const GridGeometry grid = grid_of({20, 20, 20});  // to 0.9, 1.2, 1.3
  const std::vector<Collider> ball{collider({Sphere{Vec3(0.4, 0.7, 0.8), 0.2}})};
  const double whole = 4.0 * std::numbers::pi * 0.04;
  EXPECT_NEAR(gauge_area(grid, part({}, 0.0), ball), whole, 0.005 * whole);
  const double cap = std::numbers::pi * 0.01;  // within 0.1 of a point of the sphere
  EXPECT_NEAR(gauge_area(grid, part(Vec3(0.4, 0.7, 1.0), 0.1), ball), cap, 0.02 * cap);
  EXPECT_EQ(gauge_area(grid, part(Vec3(0.4, 0.7, 0.8), 0.1), ball), 0.0);

  const std::vector<Collider> floor{collider({Plane{Vec3(0.0, 0.0, 0.4), Vec3::UnitZ()}})};
  EXPECT_NEAR(gauge_area(grid, part({}, 0.0), floor), 1.0, 1e-9);
  EXPECT_NEAR(gauge_area(grid, part(Vec3(0.4, 0.7, 0.4), 0.1), floor), cap, 0.01 * cap);
  EXPECT_NEAR(gauge_area(grid, part(Vec3(-0.1, 0.7, 0.4), 0.1), floor), 0.5 * cap, 0.01 * cap);
}

TEST(Gauge, SharesOnColliders) {
  const GridGeometry grid = grid_of({20, 20, 20});
  const Collider floor = collider({Plane{Vec3(0.0, 0.0, 0.4), Vec3::UnitZ()}});
  Gauge gauge;
  gauge.collider_number = 0;
  EXPECT_EQ(collider_share(grid, gauge, floor, {}, Vec3(0.1, 0.5, 0.35)), 1.0);
  gauge.lower = Vec3(0.1, 0.2, 0.3);
  gauge.upper = Vec3(0.2, 0.9, 0.5);
  EXPECT_EQ(collider_share(grid, gauge, floor, {}, Vec3(0.15, 0.5, 0.2)), 1.0) << "by the point of the surface above it";
  EXPECT_EQ(collider_share(grid, gauge, floor, {}, Vec3(0.1, 0.5, 0.4)), 0.5);
  EXPECT_EQ(collider_share(grid, gauge, floor, {}, Vec3(0.1, 0.2, 0.4)), 0.25);
  EXPECT_EQ(collider_share(grid, gauge, floor, {}, Vec3(0.5, 0.5, 0.4)), 0.0);
  // Moved by (1, 0, 0.1) the patch is there.
  const Pose pose{Mat3::Identity(), Vec3(1.0, 0.0, 0.1)};
  EXPECT_EQ(collider_share(grid, gauge, floor, pose, Vec3(1.1, 0.5, 0.5)), 0.5);
  EXPECT_EQ(collider_share(grid, gauge, floor, pose, Vec3(0.1, 0.5, 0.5)), 0.0);
}

}  // namespace
}  // namespace bulkley::gauge_test
