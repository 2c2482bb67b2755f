#include "geometry/triangle_mesh.hpp"

#include <gtest/gtest.h>

#include "support/sample_meshes.hpp"

namespace bulkley::triangle_mesh_test {
namespace {

using testing_support::cube;

/// Each triangle with corners of its own, as STL has them.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (const Int3& t : mesh.triangles) {
    const int first = static_cast<int>(result.vertices.size());
    for (const int v : t) result.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

TEST(TriangleMesh, FactsOfACube) {
  const MeshFacts f = facts(cube());
  EXPECT_TRUE(f.closed());
  EXPECT_EQ(f.n_holes, 0u);
  EXPECT_EQ(f.n_components, 1u);
  EXPECT_DOUBLE_EQ(f.volume, 1.0);
  EXPECT_DOUBLE_EQ(f.area, 6.0);
  EXPECT_EQ(f.lower, Vec3(0.0, 0.0, 0.0));
  EXPECT_EQ(f.upper, Vec3(1.0, 1.0, 1.0));
}

TEST(TriangleMesh, WeldingJoinsWhatStlTakesApart) {
  TriangleMesh mesh = soup(cube());
  mesh.vertices[0] = Vec3(-0.0, 0.0, -0.0);
  EXPECT_EQ(facts(mesh).n_components, 12u);
  const WeldCount count = weld(mesh);
  EXPECT_EQ(count.vertices, 28u);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_TRUE(facts(mesh).closed());
}

TEST(TriangleMesh, WeldingDropsTrianglesWithoutAreaAndRepeatedOnes) {
  TriangleMesh mesh = cube();
  mesh.triangles.push_back({3, 0, 1});  // the first one, from another corner
  mesh.triangles.push_back({3, 3, 5});
  mesh.vertices.push_back(Vec3(9.0, 9.0, 9.0));  // of no triangle
  const WeldCount count = weld(mesh);
  EXPECT_EQ(count.duplicates, 1u);
  EXPECT_EQ(count.degenerate, 1u);
  EXPECT_EQ(mesh.triangles, cube().triangles);
  EXPECT_EQ(mesh.vertices.size(), 8u);
}

TEST(TriangleMesh, HolesAreCounted) {
  TriangleMesh one = cube(), two = cube();
  std::erase(one.triangles, Int3{0, 1, 3});
  EXPECT_EQ(facts(one).n_holes, 1u);
  EXPECT_EQ(facts(one).n_boundary_edges, 3u);
  std::erase(two.triangles, Int3{0, 1, 3});
  std::erase(two.triangles, Int3{4, 7, 5});
  std::erase(two.triangles, Int3{4, 6, 7});
  EXPECT_EQ(facts(two).n_holes, 2u);
  EXPECT_EQ(facts(two).n_boundary_edges, 7u);
}

TEST(TriangleMesh, VolumeIsThatOfTheMeshWithItsHolesClosed) {
  TriangleMesh mesh = cube();
  for (Vec3& v : mesh.vertices) v += Vec3(7.0, 8.0, 9.0);
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);  // a whole face
  EXPECT_EQ(facts(mesh).n_holes, 1u);
  EXPECT_NEAR(facts(mesh).volume, 1.0, 1e-14);
  EXPECT_NEAR(facts(testing_support::turned_inside_out(mesh)).volume, -1.0, 1e-14);
}

TEST(TriangleMesh, TurnedTriangleIsNoPartOfAClosedMesh) {
  TriangleMesh mesh = cube();
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  EXPECT_FALSE(facts(mesh).closed());
}

TEST(TriangleMesh, InwardMeshHasNegativeVolume) {
  EXPECT_DOUBLE_EQ(facts(testing_support::turned_inside_out(cube())).volume, -1.0);
}

}  // namespace
}  // namespace bulkley::triangle_mesh_test
