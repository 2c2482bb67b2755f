#include "geometry/surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "geometry/mesh_solid.hpp"

namespace bulkley::surface_test {
namespace {

const Bounds window{{-1.0, -1.0, -1.0}, {1.0, 1.5, 1.0}};
constexpr double window_volume = 2.0 * 2.5 * 2.0;

/// The largest distance of a vertex from the surface of `shape`.
double worst_vertex(const TriangleMesh& mesh, const Shape& shape) {
  double worst = 0.0;
  for (const Vec3& x : mesh.vertices) worst = std::max(worst, std::abs(signed_distance(shape, x)));
  return worst;
}

Shape placed(const Shape& part) {
  return {Placed{std::make_shared<const Shape>(part), Vec3(1.0, -1.0, 0.5), 0.7, Vec3(0.1, 0.2, 0.3), Vec3(0.3, -0.1, 0.2)}};
}

// Facets lie inside of a round body: its volume is a little less, but not by more than 1 %.
TEST(Surface, OfPrimitivesIsClosedFacesOutwardsAndLiesOnThem) {
  const double pi = std::numbers::pi, length = Vec3(0.5, 0.5, 0.2).norm();
  const Vec3 start(-0.2, -0.1, 0.0), end(0.3, 0.4, 0.2);
  const std::vector<std::pair<Shape, double>> cases{
      {{Box{{-0.1, 0.2, -0.3}, {0.5, 0.6, 0.4}}}, 0.6 * 0.4 * 0.7},
      {{Sphere{{0.1, -0.2, 0.3}, 0.4}}, 4.0 / 3.0 * pi * 0.064},
      {{Cylinder{start, end, 0.25}}, pi * 0.0625 * length},
      {{Capsule{start, end, 0.25}}, pi * 0.0625 * length + 4.0 / 3.0 * pi * 0.015625},
      {{Capsule{start, start, 0.25}}, 4.0 / 3.0 * pi * 0.015625},
      {{Ellipsoid{{0.1, -0.1, 0.2}, {0.7, 0.3, 0.15}}}, 4.0 / 3.0 * pi * 0.7 * 0.3 * 0.15}};
  for (const auto& [shape, volume] : cases)
    for (const Shape& each : {shape, placed(shape)}) {
      const TriangleMesh mesh = surface_of(each, window);
      const MeshFacts found = facts(mesh);
      EXPECT_TRUE(found.closed()) << shape.kind.index();
      EXPECT_LE(found.volume, volume * (1.0 + 1e-12)) << shape.kind.index();
      EXPECT_GE(found.volume, volume * 0.99) << shape.kind.index();
      EXPECT_LT(worst_vertex(mesh, each), 1e-12) << shape.kind.index();
    }
}

TEST(Surface, OfAHalfSpaceFillsTheWindowBehindIt) {
  const Shape level{Plane{{0.0, 0.0, 0.25}, {0.0, 0.0, 3.0}}};
  MeshFacts found = facts(surface_of(level, window));
  EXPECT_TRUE(found.closed());
  EXPECT_NEAR(found.volume, window_volume * 1.25 / 2.0, 1e-12);

  // A corner cut off: x + y + z <= -2.5 leaves a tetrahedron with edges of half a metre.
  const Shape corner{Plane{{-2.5, 0.0, 0.0}, {1.0, 1.0, 1.0}}};
  found = facts(surface_of(corner, window));
  EXPECT_TRUE(found.closed());
  EXPECT_NEAR(found.volume, 0.125 / 6.0, 1e-12);

  // Turned by the same angle as its normal would be.
  const Shape turned{
      Placed{std::make_shared<const Shape>(level), Vec3::UnitX(), std::numbers::pi, Vec3::Zero(), Vec3::Zero()}};
  found = facts(surface_of(turned, window));
  EXPECT_NEAR(found.volume, window_volume * 1.25 / 2.0, 1e-12) << "all above z = -0.25";
  EXPECT_NEAR(found.lower.z(), -0.25, 1e-12);

  EXPECT_TRUE(surface_of({Plane{{0.0, 0.0, -2.0}, {0.0, 0.0, 1.0}}}, window).triangles.empty());
}

TEST(Surface, OfDifferenceAndComplementIsTraced) {
  const Vec3 start(0.1, 0.2, -0.5), end(0.1, 0.2, 0.5);
  const Shape tube{Difference{{{Cylinder{start, end, 0.4}}, {Cylinder{start, end, 0.25}}}}};
  const double tube_volume = std::numbers::pi * (0.16 - 0.0625) * 1.0;
  for (const Shape& each : {tube, placed(tube)}) {
    const TriangleMesh mesh = surface_of(each, window);
    const MeshFacts found = facts(mesh);
    EXPECT_TRUE(found.closed());
    EXPECT_NEAR(found.volume, tube_volume, 0.02 * tube_volume);
    EXPECT_LT(worst_vertex(mesh, each), 2e-3) << "a tenth of a cell of the lattice";
  }

  const Shape bore{Complement{Union{{{Cylinder{{-2.0, 0.2, 0.0}, {2.0, 0.2, 0.0}, 0.5}}}}}};
  const TriangleMesh pipe = surface_of(bore, window);
  const MeshFacts found = facts(pipe);
  const double solid = window_volume - std::numbers::pi * 0.25 * 2.0;
  EXPECT_TRUE(found.closed());
  EXPECT_NEAR(found.volume, solid, 0.01 * solid);
  EXPECT_LT((found.lower - window.lower).norm() + (found.upper - window.upper).norm(), 1e-6) << "the window closes it";
}

TEST(Surface, OfAUnionIsThatOfItsParts) {
  const Shape a{Box{{0.0, 0.0, 0.0}, {0.2, 0.2, 0.2}}}, b{Sphere{{0.1, 0.1, 0.3}, 0.1}};
  const TriangleMesh both = surface_of({Union{{a, b}}}, window);
  const MeshFacts found = facts(both);
  EXPECT_EQ(found.n_components, 2u);
  EXPECT_NEAR(found.volume, facts(surface_of(a, window)).volume + facts(surface_of(b, window)).volume, 1e-12);
}

TEST(Surface, OfAMeshIsTheMesh) {
  const TriangleMesh triangles = surface_of({Box{{0.0, 0.0, 0.0}, {0.2, 0.3, 0.4}}}, window);
  Mesh mesh;
  mesh.solid = std::make_shared<const MeshSolid>(triangles);
  EXPECT_EQ(surface_of({mesh}, window).triangles, triangles.triangles);
  EXPECT_TRUE(surface_of({Mesh{}}, window).triangles.empty());
}

}  // namespace
}  // namespace bulkley::surface_test
