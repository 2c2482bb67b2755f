#include "bulkley/particle/mesh_solid.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "bulkley/particle/isosurface.hpp"

namespace bulkley {
namespace {

double ball(const Vec3& x) { return x.norm() - 0.5; }
double torus(const Vec3& x) { return std::hypot(std::hypot(x[0], x[1]) - 0.5, x[2]) - 0.2; }

constexpr double spacing = 0.02;
TriangleMesh meshed(double (*f)(const Vec3&)) { return isosurface(f, Vec3::Constant(-0.8), Vec3::Constant(0.8), spacing); }

std::vector<Vec3> random_points(int count) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Vec3> points;
  for (int n = 0; n < count; ++n) points.push_back(Vec3(uniform(generator), uniform(generator), uniform(generator)));
  return points;
}

/// How far the vertices of a mesh, and so its faces, may lie from the true surface of curvature up to 5/m.
constexpr double mesh_error = 3.0 * spacing * spacing * 5.0 / 4.0;

struct Errors {
  int wrong = 0;         ///< points farther than mesh_error from the surface on the wrong side
  double winding = 0.0;  ///< largest error of w at points farther than `spacing` from the surface
  double distance = 0.0, normal = 0.0;
};

Errors errors(const MeshSolid& solid, double (*f)(const Vec3&)) {
  Errors result;
  for (const Vec3& x : random_points(20000)) {
    const double exact = f(x);
    if (std::abs(exact) > mesh_error && solid.contains(x) != (exact < 0.0)) ++result.wrong;
    if (std::abs(exact) > spacing)
      result.winding = std::max(result.winding, std::abs(solid.winding_number(x) - (exact < 0.0 ? 1.0 : 0.0)));
    result.distance = std::max(result.distance, std::abs(solid.signed_distance(x) - exact));
  }
  return result;
}

TEST(MeshSolid, Look) {
  for (auto f : {ball, torus}) {
    const TriangleMesh mesh = meshed(f);
    const auto t0 = std::chrono::steady_clock::now();
    const MeshSolid solid(mesh);
    const auto t1 = std::chrono::steady_clock::now();
    const Errors e = errors(solid, f);
    const auto points = random_points(100000);
    const auto t2 = std::chrono::steady_clock::now();
    double s = 0;
    for (const Vec3& x : points) s += solid.winding_number(x);
    const auto t3 = std::chrono::steady_clock::now();
    for (const Vec3& x : points) s += solid.nearest(x).distance;
    const auto t4 = std::chrono::steady_clock::now();
    auto seconds = [](auto a, auto b) { return std::chrono::duration<double>(b - a).count(); };
    printf("%zu triangles, build %g s, w %g us, d %g us, wrong %d, w error %g, d error %g  (%g)\n", mesh.triangles.size(),
           seconds(t0, t1), 10 * seconds(t2, t3), 10 * seconds(t3, t4), e.wrong, e.winding, e.distance, s);
  }
}
}  // namespace
}  // namespace bulkley
