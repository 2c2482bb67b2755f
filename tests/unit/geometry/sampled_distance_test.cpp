#include "geometry/sampled_distance.hpp"

#include <gtest/gtest.h>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_shape.hpp"
#include "support/sample_meshes.hpp"

namespace bulkley::sampled_distance_test {
namespace {

using namespace testing_support;

constexpr double spacing = 0.02, band = 0.16;

TEST(SampledDistance, DistanceAndNormalOfATorus) {
  const auto solid = std::make_shared<const MeshSolid>(meshed(torus));
  const SampledDistance sampled(solid, spacing, band);
  for (const Vec3& x : random_points(20000)) {
    const double d = torus(x);
    if (std::abs(d) > 0.9 * band) {
      EXPECT_GE(std::abs(sampled.distance(x)), 0.85 * band);
      EXPECT_EQ(sampled.distance(x) > 0.0, d > 0.0);
      continue;
    }
    if (std::abs(d) > 0.1) continue;  // curvature grows towards the core
    // Trilinear interpolation of curvatures up to 1 / (0.2 - 0.1) in two directions.
    EXPECT_NEAR(sampled.distance(x), d, mesh_error + 2.0 * spacing * spacing * 10.0 / 8.0);
    const Vec3 ring = 0.5 * Vec3(x[0], x[1], 0.0).normalized();
    EXPECT_LE((sampled.normal(x) - (x - ring).normalized()).norm(), 0.05);
  }
}

TEST(SampledDistance, LookupsInAnyOrderGiveTheSameBits) {
  const auto solid = std::make_shared<const MeshSolid>(meshed(ball));
  const SampledDistance one(solid, spacing, band), other(solid, spacing, band);
  const std::vector<Vec3> points = random_points(2000);
  std::vector<double> values;
  for (const Vec3& x : points) values.push_back(one.distance(x));
  for (std::size_t n = points.size(); n-- > 0;) EXPECT_EQ(other.distance(points[n]), values[n]);
}

TEST(SampledDistance, ReplacesEveryMeshOfAShape) {
  Mesh mesh;
  mesh.center = Vec3(0.2, 0.0, 0.0);
  const Shape solid{filled(mesh, meshed(ball))};
  const Shape all{
      Placed{std::make_shared<const Shape>(Shape{Union{{solid, {Sphere{{5.0, 0.0, 0.0}, 0.5}}}}}), Vec3::UnitZ(), 0.5}};
  const Shape sampled = sampled_for_contact(all, 0.05);
  int n_sampled = 0;
  visit_meshes(sampled, [&](const Mesh& m) { n_sampled += m.sampled ? 1 : 0; });
  EXPECT_EQ(n_sampled, 1);
  for (const Vec3& x : random_points(1000))
    if (std::abs(signed_distance(all, x)) < 0.1) {
      EXPECT_NEAR(signed_distance(sampled, x), signed_distance(all, x), 0.002);
      EXPECT_GE(outward_normal(sampled, x).dot(outward_normal(all, x)), 0.98);
    }
}

TEST(SampledDistance, RefusesMoreCellsThanMemoryHolds) {
  const auto solid = std::make_shared<const MeshSolid>(cube());
  EXPECT_THROW(SampledDistance(solid, 1e-5, 1e-4), UsageError);
}

}  // namespace
}  // namespace bulkley::sampled_distance_test
