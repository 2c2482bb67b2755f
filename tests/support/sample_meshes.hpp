#pragma once
// Meshes of shapes whose distance is known exactly.

#include <cmath>
#include <random>
#include <vector>

#include "geometry/isosurface.hpp"

namespace bulkley::testing_support {

constexpr double mesh_spacing = 0.02;
/// How far a mesh made with that spacing may lie from a surface with curvatures up to 5/m: over the lattice's space diagonal d
/// linear interpolation errs by d^2 / 8 times the curvature, and a face between such vertices by as much again.
constexpr double mesh_error = 2.0 * 3.0 * mesh_spacing * mesh_spacing * 5.0 / 8.0;

inline double ball(const Vec3& x) { return x.norm() - 0.5; }
inline double torus(const Vec3& x) { return std::hypot(std::hypot(x[0], x[1]) - 0.5, x[2]) - 0.2; }

inline TriangleMesh meshed(double (*distance)(const Vec3&)) {
  return isosurface(distance, Vec3::Constant(-0.8), Vec3::Constant(0.8), mesh_spacing);
}

inline TriangleMesh cube() {
  TriangleMesh mesh;
  for (int n = 0; n < 8; ++n) mesh.vertices.push_back(Vec3(n >> 2, n >> 1 & 1, n & 1));
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return mesh;
}

/// The mesh without the triangles whose first corner `drop` picks.
template <class Predicate>
TriangleMesh without(TriangleMesh mesh, const Predicate& drop) {
  std::erase_if(mesh.triangles, [&](const Int3& t) { return drop(mesh.vertices[static_cast<std::size_t>(t[0])]); });
  weld(mesh);
  return mesh;
}

inline TriangleMesh turned_inside_out(TriangleMesh mesh) {
  for (Int3& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

inline std::vector<Vec3> random_points(int count, double half_width = 1.0) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-half_width, half_width);
  std::vector<Vec3> points;
  for (int n = 0; n < count; ++n) {
    const double x = uniform(generator), y = uniform(generator), z = uniform(generator);
    points.push_back(Vec3(x, y, z));
  }
  return points;
}

}  // namespace bulkley::testing_support
