#include "geometry/mesh_shape.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "bulkley/base/error.hpp"
#include "geometry/builtin_mesh.hpp"
#include "particle/seeding.hpp"
#include "support/sample_meshes.hpp"

namespace bulkley::mesh_shape_test {
namespace {

using namespace testing_support;

Mesh scaled(double scale) {
  Mesh mesh;
  mesh.scale = scale;
  return mesh;
}
Mesh sized(double size, const Vec3& center) {
  Mesh mesh;
  mesh.size = size;
  mesh.center = center;
  return mesh;
}
Mesh turned(Axis up) {
  Mesh mesh;
  mesh.up = up;
  return mesh;
}

Bounds placed_bounds(const Mesh& mesh, TriangleMesh triangles) { return bounds({filled(mesh, std::move(triangles))}); }

void expect_bounds(const Bounds& b, const Vec3& lower, const Vec3& upper) {
  EXPECT_LE((b.lower - lower).norm(), 1e-14);
  EXPECT_LE((b.upper - upper).norm(), 1e-14);
}

/// 1 x 2 x 3, the corner of most triangles at the origin.
TriangleMesh brick() {
  TriangleMesh mesh = cube();
  for (Vec3& v : mesh.vertices) v = v.cwiseProduct(Vec3(1.0, 2.0, 3.0));
  return mesh;
}

TEST(MeshShape, PlacementByScaleSizeCenterAndUp) {
  expect_bounds(placed_bounds({}, brick()), Vec3(0, 0, 0), Vec3(1, 2, 3));
  expect_bounds(placed_bounds(scaled(0.1), brick()), Vec3(0, 0, 0), Vec3(0.1, 0.2, 0.3));
  expect_bounds(placed_bounds(sized(6.0, Vec3(0, 0, 3)), brick()), Vec3(-1, -2, 0), Vec3(1, 2, 6));
  expect_bounds(placed_bounds(turned(Axis::y), brick()), Vec3(0, -3, 0), Vec3(1, 0, 2));
  expect_bounds(placed_bounds(turned(Axis::x), brick()), Vec3(-3, 0, 0), Vec3(0, 2, 1));
}

TEST(MeshShape, QuarterTurnsKeepInsideInside) {
  for (const Axis up : {Axis::x, Axis::y, Axis::z}) {
    const Mesh mesh = filled(turned(up), brick());
    EXPECT_DOUBLE_EQ(mesh.solid->facts().volume, 6.0);
    EXPECT_TRUE(contains({mesh}, bounds({mesh}).center()));
  }
}

TEST(MeshShape, WorksInsideOtherShapes) {
  const Shape mesh{filled({}, cube())};
  const Shape hollow{Difference{{mesh, {Sphere{{0.5, 0.5, 0.5}, 0.25}}}}};
  const Shape placed{Placed{std::make_shared<const Shape>(hollow), Vec3::UnitZ(), 0.0, Vec3::Zero(), Vec3(3.0, 0.0, 0.0)}};
  EXPECT_NEAR(signed_distance(placed, Vec3(3.5, 0.5, 0.5)), 0.25, 1e-15);
  EXPECT_FALSE(contains(placed, Vec3(3.5, 0.5, 0.5)));
  EXPECT_TRUE(contains(placed, Vec3(3.1, 0.5, 0.5)));
  EXPECT_NEAR(signed_distance({Complement{{{mesh}}}}, Vec3(0.5, 0.5, 0.9)), 0.1, 1e-15);
  EXPECT_FALSE(waits_for_mesh(placed));
  EXPECT_TRUE(waits_for_mesh({Union{{mesh, {Mesh{}}}}}));
}

void expect_fault(TriangleMesh mesh, const std::string& words) {
  try {
    weld_checked(mesh);
    filled({}, mesh);
    ADD_FAILURE() << "accepted, instead of: " << words;
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(MeshShape, UnusableMeshesAreRefused) {
  expect_fault({}, "holds no triangle");
  TriangleMesh mesh = cube();
  mesh.triangles[3][1] = 8;
  expect_fault(mesh, "vertex 8, but only 8 vertices");
  mesh = cube();
  mesh.vertices[5][1] = std::numeric_limits<double>::quiet_NaN();
  expect_fault(mesh, "1 of 8 vertices");
  mesh = cube();
  for (Vec3& v : mesh.vertices) v = Vec3(v[0], v[0], v[0]);
  expect_fault(mesh, "none of which has an area");
  mesh = cube();
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}};
  expect_fault(mesh, "encloses nothing");
}

/// Seeded over true volume, at so many cells across the largest side.
double filling(const Mesh& mesh, int cells) {
  const Shape shape{mesh};
  const Bounds b = bounds(shape);
  const double cell = (b.upper - b.lower).maxCoeff() / cells;
  GridGeometry grid;
  grid.lower = b.lower - Vec3::Constant(1.3 * cell);
  grid.cell_size = cell;
  grid.n_cells = {cells + 3, cells + 3, cells + 3};
  Body body;
  body.shape = shape;
  const auto n = static_cast<double>(count_particles(grid, {body}, 0, grid.n_tiles()).n_particles());
  return n * cell * cell * cell / 8.0 / std::abs(mesh.solid->facts().volume);
}

TEST(MeshShape, SeededVolumeIsThatOfTheMesh) {
  EXPECT_NEAR(filling(filled({}, meshed(torus)), 40), 1.0, 0.01);
  for (const std::string& name : builtin_meshes())
    for (const Axis up : {Axis::y, Axis::z})
      EXPECT_NEAR(filling(filled(turned(up), builtin_mesh(name)), 40), 1.0, 0.01) << name;
}

TEST(MeshShape, BuiltinFiguresAreClosedAndInOnePiece) {
  ASSERT_EQ(builtin_meshes().size(), 2u);
  for (const std::string& name : builtin_meshes()) {
    TriangleMesh mesh = builtin_mesh(name);
    const std::size_t n = mesh.triangles.size();
    EXPECT_EQ(weld_checked(mesh).duplicates, 0u);
    EXPECT_EQ(mesh.triangles.size(), n);
    const MeshFacts f = facts(mesh);
    EXPECT_TRUE(f.closed()) << name;
    EXPECT_EQ(f.n_components, 1u) << name;
    EXPECT_GT(f.volume, 0.0) << name;
    const Vec3 size = f.upper - f.lower;
    EXPECT_LT(f.volume, 0.3 * size.prod()) << name << " is far from convex";
  }
  EXPECT_THROW(builtin_mesh("rabbit"), UsageError);
}

}  // namespace
}  // namespace bulkley::mesh_shape_test
