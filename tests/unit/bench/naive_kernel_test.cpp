// The yardstick of the benchmark must be right too: it takes the same steps as the reference MPM.

#include <gtest/gtest.h>

#include "bench/naive_kernel.cpp"  // NOLINT: unit tests link no support sources
#include "support/reference_mpm.hpp"

namespace bulkley::naive_kernel_test {
namespace {

Mat3 matrix(const double* rows) { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows); }

TEST(NaiveKernel, TakesTheStepsOfTheReference) {
  const int n_cells = 14;
  NaiveKernel naive(n_cells, 0.25);
  ASSERT_GT(naive.size(), 500);

  ReferenceScene scene;
  scene.grid.cell_size = 1.0 / n_cells;
  scene.grid.n_cells = {n_cells, n_cells, n_cells};
  scene.gravity = Vec3(0.0, 0.0, -naive.gravity());
  scene.materials = {{naive.bulk_modulus(), naive.shear_modulus(), false, 0.0, 0.0, 1.0}};
  // Sticky to the depth of three nodes, planes on the last of them, as the naive kernel's walls (nodes 0 .. 2 and 11 .. 13).
  const double depth = 2.0 / n_cells, high = 11.0 / n_cells;
  for (int a = 0; a < 3; ++a) {
    scene.colliders.push_back({"low", {Plane{depth * Vec3::Unit(a), Vec3::Unit(a)}}, Contact::sticky, 0.0});
    scene.colliders.push_back({"high", {Plane{high * Vec3::Unit(a), -Vec3::Unit(a)}}, Contact::sticky, 0.0});
  }
  std::vector<ReferenceParticle> start;
  for (const NaiveParticle& p : naive.particles()) {
    ReferenceParticle r;
    r.x = Vec3(p.x[0], p.x[1], p.x[2]);
    r.v = Vec3(p.v[0], p.v[1], p.v[2]);
    r.C = r.L = matrix(p.C);
    r.m = naive.particle_mass();
    r.V = naive.particle_volume();
    advance_state(scene.materials[0], naive.time_step(), r);  // the naive kernel advances F at the start of a step
    start.push_back(r);
  }
  ReferenceMpm reference(scene, start);

  for (int step = 0; step < 30; ++step) {
    EXPECT_GT(naive.step(), 0.0);
    reference.step(naive.time_step());
  }
  double largest_change = 0.0;
  for (std::size_t p = 0; p < start.size(); ++p) {
    const NaiveParticle& n = naive.particles()[p];
    const ReferenceParticle& r = reference.particles[p];
    EXPECT_LE((Vec3(n.x[0], n.x[1], n.x[2]) - r.x).norm(), 1e-12);
    EXPECT_LE((Vec3(n.v[0], n.v[1], n.v[2]) - r.v).norm(), 1e-10);
    EXPECT_LE((matrix(n.C) - r.C).norm(), 1e-8);
    largest_change = std::max(largest_change, (r.v - start[p].v).norm());
  }
  EXPECT_GT(largest_change, 0.05);  // stress and gravity did act
}

TEST(NaiveKernel, FillsABallOfTheAskedVolume) {
  const double ball = 4.0 / 3.0 * 3.14159265358979323846 * 0.3 * 0.3 * 0.3;
  for (const int per_cell : {1, 8, 27}) {
    const NaiveKernel naive(40, 0.3, per_cell);
    EXPECT_NEAR(static_cast<double>(naive.size()) * naive.particle_volume(), ball, 5e-3 * ball);
  }
}

TEST(NaiveKernel, RefusesWhatItCannotHold) {
  EXPECT_THROW(NaiveKernel(20, 0.2, 9), UsageError);
  EXPECT_THROW(NaiveKernel(20, 0.41), UsageError);
  EXPECT_THROW(NaiveKernel(20, -0.1), UsageError);
}

}  // namespace
}  // namespace bulkley::naive_kernel_test
