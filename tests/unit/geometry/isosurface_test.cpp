#include "geometry/isosurface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bulkley::isosurface_test {
namespace {

/// What the lattice cuts off sharp edges: of each at most a prism over half a square of the lattice.
double cut_off(double length_of_edges, double spacing) { return 0.5 * length_of_edges * spacing * spacing; }

double torus(const Vec3& x) { return std::hypot(std::hypot(x[0], x[1]) - 0.7, x[2]) - 0.2; }

TEST(Isosurface, TorusIsClosedInOnePieceAndFacesOutwards) {
  const TriangleMesh mesh = isosurface(torus, Vec3(-1.0, -1.0, -0.3), Vec3(1.0, 1.0, 0.3), 0.02);
  const MeshFacts f = facts(mesh);
  EXPECT_TRUE(f.closed());
  EXPECT_EQ(f.n_components, 1u);
  const double exact = 2.0 * std::numbers::pi * std::numbers::pi * 0.7 * 0.04;
  EXPECT_NEAR(f.volume, exact, 0.01 * exact);
  // Genus one: as many vertices and triangles as edges.
  EXPECT_EQ(2 * mesh.vertices.size(), mesh.triangles.size());
  // Linear interpolation over a space diagonal d of the lattice, of a function with curvature 1/0.2: at most d^2 / (8 * 0.2).
  for (const Vec3& v : mesh.vertices) EXPECT_NEAR(torus(v), 0.0, 3.0 * 0.02 * 0.02 / (8.0 * 0.2));
}

TEST(Isosurface, MeshHasNoTriangleWithoutAreaWhereLatticePointsLieOnTheSurface) {
  const auto cube = [](const Vec3& x) { return x.cwiseAbs().maxCoeff() - 0.5; };
  TriangleMesh mesh = isosurface(cube, Vec3::Constant(-1.0), Vec3::Constant(1.0), 0.1);
  const MeshFacts f = facts(mesh);
  EXPECT_TRUE(f.closed());
  EXPECT_LE(f.volume, 1.0);
  EXPECT_GE(f.volume, 1.0 - cut_off(12.0, 0.1));
  const WeldCount count = weld(mesh);
  EXPECT_EQ(count.vertices + count.degenerate + count.duplicates, 0u);
}

TEST(Isosurface, FacesOfTheBoxCloseWhatReachesThem) {
  const auto half_space = [](const Vec3& x) { return x[2] - 0.25; };
  const MeshFacts f = facts(isosurface(half_space, Vec3::Zero(), Vec3(1.0, 2.0, 1.0), 0.1));
  EXPECT_TRUE(f.closed());
  EXPECT_LE(f.volume, 0.5);
  EXPECT_GE(f.volume, 0.5 - cut_off(4.0 * (1.0 + 2.0 + 0.25), 0.1));
  EXPECT_NEAR(f.lower.norm(), 0.0, 1e-4);
  EXPECT_NEAR((f.upper - Vec3(1.0, 2.0, 0.25)).norm(), 0.0, 1e-4);
}

TEST(Isosurface, NothingInsideGivesAnEmptyMesh) {
  const auto nowhere = [](const Vec3&) { return 1.0; };
  EXPECT_TRUE(isosurface(nowhere, Vec3::Zero(), Vec3::Ones(), 0.5).triangles.empty());
}

}  // namespace
}  // namespace bulkley::isosurface_test
