#include "geometry/mesh_solid.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "support/sample_meshes.hpp"

namespace bulkley::mesh_solid_test {
namespace {

using namespace testing_support;

struct Errors {
  int wrong_side = 0;     ///< points farther than mesh_error from the true surface
  double winding = 0.0;   ///< of points farther than a triangle from it
  double distance = 0.0;  ///< m
};

Errors errors(const MeshSolid& solid, double (*exact)(const Vec3&)) {
  Errors result;
  for (const Vec3& x : random_points(5000)) {
    const double d = exact(x);
    if (std::abs(d) > mesh_error && solid.contains(x) != (d < 0.0)) ++result.wrong_side;
    if (std::abs(d) > mesh_spacing)
      result.winding = std::max(result.winding, std::abs(solid.winding_number(x) - (d < 0.0 ? 1.0 : 0.0)));
    result.distance = std::max(result.distance, std::abs(solid.signed_distance(x) - d));
  }
  return result;
}

void expect_exact(const MeshSolid& solid, double (*exact)(const Vec3&)) {
  const Errors e = errors(solid, exact);
  EXPECT_EQ(e.wrong_side, 0);
  EXPECT_LE(e.winding, 0.1);  // far from 1/2, which decides
  EXPECT_LE(e.distance, mesh_error);
}

TEST(MeshSolid, ClosedMeshesHaveTheDistanceOfTheirShapes) {
  expect_exact(MeshSolid(meshed(ball)), ball);
  expect_exact(MeshSolid(meshed(torus)), torus);
}

TEST(MeshSolid, WindingNumberOfACube) {
  const MeshSolid solid(cube());
  EXPECT_NEAR(solid.winding_number(Vec3::Constant(0.5)), 1.0, 1e-12);
  EXPECT_NEAR(solid.winding_number(Vec3(0.9, 0.1, 0.99)), 1.0, 1e-12);
  EXPECT_NEAR(solid.winding_number(Vec3(0.5, 0.5, 1.01)), 0.0, 1e-12);
  EXPECT_NEAR(solid.signed_distance(Vec3(0.5, 0.75, 0.5)), -0.25, 1e-15);
  EXPECT_NEAR(solid.signed_distance(Vec3(4.0, 0.5, 5.0)), 5.0, 1e-15);
  EXPECT_LE((solid.outward_normal(Vec3(0.5, 0.9, 0.5)) - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LE((solid.outward_normal(Vec3(0.5, 1.9, 0.5)) - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LE((solid.outward_normal(Vec3(0.25, 0.125, 0.0)) + Vec3::UnitZ()).norm(), 1e-15);  // on the surface
}

TEST(MeshSolid, MeshThatFacesInwardsIsTurned) {
  expect_exact(MeshSolid(turned_inside_out(meshed(torus))), torus);
  EXPECT_LE((MeshSolid(turned_inside_out(cube())).outward_normal(Vec3(0.25, 0.125, 0.0)) + Vec3::UnitZ()).norm(), 1e-15);
}

TEST(MeshSolid, RepeatedTrianglesChangeNoSide) {
  TriangleMesh mesh = meshed(ball);
  const std::size_t n = mesh.triangles.size();
  for (std::size_t t = 0; t < n; t += 3) mesh.triangles.push_back(Int3(mesh.triangles[t]));
  EXPECT_EQ(errors(MeshSolid(mesh), ball).wrong_side, 0);
}

TEST(MeshSolid, MissingTrianglesLeakNothing) {
  TriangleMesh mesh = meshed(torus);
  std::mt19937_64 generator(5);
  std::erase_if(mesh.triangles, [&](const Int3&) { return generator() % 50 == 0; });
  const MeshSolid solid(mesh);
  EXPECT_GT(solid.facts().n_holes, 100u);
  EXPECT_EQ(errors(solid, torus).wrong_side, 0);
}

TEST(MeshSolid, CutOffCapIsClosedNearItsRim) {
  const double cut = 0.4;  // the cap above it is 0.1 high and 0.6 wide
  const MeshSolid solid(without(meshed(ball), [&](const Vec3& v) { return v[2] > cut; }));
  EXPECT_EQ(solid.facts().n_holes, 1u);
  for (const Vec3& x : random_points(5000, 0.6)) {
    const double d = ball(x);
    // Somewhere in the cap the surface of winding number 1/2 closes the hole.
    if (std::abs(d) < mesh_error || (x[2] > cut - 2.0 * mesh_spacing && d < mesh_error)) continue;
    EXPECT_EQ(solid.contains(x), d < 0.0) << x.transpose();
  }
}

TEST(MeshSolid, DistanceVanishesWhereAHoleIsClosedAndIsNowhereTooLarge) {
  const MeshSolid solid(without(meshed(ball), [](const Vec3& v) { return v[2] > 0.0; }));  // a bowl: closed by its disc
  for (const double x : {0.0, 0.1, 0.2, 0.3})
    for (const double z : {-0.2, -0.1, -0.05, 0.05, 0.1, 0.2}) {
      const double d = solid.signed_distance(Vec3(x, 0.0, z));
      EXPECT_EQ(d < 0.0, z < 0.0);
      EXPECT_LE(std::abs(d), std::abs(z) + mesh_spacing) << x << " " << z;
    }
  EXPECT_LE(std::abs(solid.signed_distance(Vec3(0.1, 0.0, 1e-3))), mesh_spacing);
}

TEST(MeshSolid, ReachBoundsTheSearchOnly) {
  const auto above = [](const Vec3& v) { return v[2] > 0.0; };
  for (const MeshSolid& solid : {MeshSolid(meshed(torus)), MeshSolid(without(meshed(ball), above))})
    for (const Vec3& x : random_points(2000)) {
      const double d = solid.signed_distance(x), within = solid.signed_distance(x, 0.1);
      if (std::abs(d) <= 0.1)
        EXPECT_NEAR(within, d, 1e-15);
      else
        EXPECT_GE(within * std::copysign(1.0, d), 0.1 - 1e-15);
    }
}

}  // namespace
}  // namespace bulkley::mesh_solid_test
