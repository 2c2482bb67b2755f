// ranks: 1 3 8
// The real solver, on any number of ranks, against the plain serial reference, step by step.
#include <gtest/gtest.h>

#include <algorithm>

#include "kernel/p2g.hpp"
#include "support/reference_particles.hpp"
#include "support/solver_run.hpp"

namespace bulkley::solver_reference_mpi_test {
namespace {

ReferenceMpm reference_of(const SolverScene& scene) {
  const Physics& physics = scene.physics;
  ReferenceScene reference{physics.grid, physics.transfer, physics.gravity, physics.faces, physics.colliders, {}};
  const auto solid = std::get<NeoHookean>(physics.materials[0].material).parameters;
  const auto fluid = std::get<HerschelBulkley>(physics.materials[1].material).parameters;
  reference.materials = {{solid.bulk_modulus, solid.shear_modulus, false, 0.0, 0.0, 1.0},
                         {fluid.bulk_modulus, fluid.shear_modulus, true, fluid.sigma_Y, fluid.eta, fluid.h}};
  return ReferenceMpm(reference, reference_particles(scene.particles, physics.materials));
}

// Largest differences over particles, each divided by the scale of its quantity.
struct Difference {
  double x = 0.0, v = 0.0, C = 0.0, J = 0.0, b = 0.0, tau = 0.0, dissipation = 0.0;
  double largest() const { return std::max({x, v, C, J, b, tau, dissipation}); }
};

Difference difference(const ReferenceMpm& reference, const ParticleSet& found, const Physics& physics) {
  const std::vector<ReferenceParticle> particles = reference_particles(found, physics.materials);
  Difference d;
  EXPECT_EQ(particles.size(), reference.particles.size());
  if (particles.size() != reference.particles.size()) return d;
  double speed = 0.0, gradient = 0.0, dissipation = 50.0;  // J/m^3, at least the yield stress
  for (const ReferenceParticle& p : reference.particles) {
    speed = std::max(speed, p.v.norm());
    gradient = std::max(gradient, p.C.norm());
    dissipation = std::max(dissipation, p.dissipation);
  }
  for (std::size_t n = 0; n < particles.size(); ++n) {
    const ReferenceParticle &p = particles[n], &truth = reference.particles[n];
    EXPECT_EQ(p.id, truth.id);
    EXPECT_EQ(p.material, truth.material);
    d.x = std::max(d.x, (p.x - truth.x).norm());
    d.v = std::max(d.v, (p.v - truth.v).norm() / speed);
    if (physics.transfer.affine()) d.C = std::max(d.C, (p.C - truth.C).norm() / gradient);
    d.J = std::max(d.J, std::abs(p.J - truth.J));
    d.b = std::max(d.b, (p.b - truth.b).norm());
    d.tau = std::max(d.tau, (p.tau - truth.tau).norm() / 1e5);
    d.dissipation = std::max(d.dissipation, std::abs(p.dissipation - truth.dissipation) / dissipation);
  }
  return d;
}

class SolverReferenceTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  // Node velocities carry the rounding of order-free sums divided by the node's mass. The MLS form sees them through w,
  // which takes the mass out again; the B-spline form through grad w, and |grad w| / w grows without bound towards the edge
  // of a particle's reach.
  static double tolerance(const TransferSettings& transfer) { return transfer.gradient == GradientForm::mls ? 1e-10 : 1e-7; }

  void expect_agreement(const SolverScene& scene, int n_steps, PartitionMethod method, bool scattered) {
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, method, scattered));
    ReferenceMpm reference = reference_of(scene);  // marches on the root only
    TimeStepState state;
    double largest_mass = 0.0;
    for (LocalIndex p = 0; p < scene.particles.size(); ++p)
      largest_mass = std::max(largest_mass, scene.particles.mass(p));
    Difference last;
    for (int step = 0; step < n_steps; ++step) {
      const double dt = scene.physics.time_stepping.dt_fixed;
      // Both draw the line of empty nodes at the same mass.
      reference.empty_node = 0x1p-48 *
                             sum_bounds(scene.physics.grid, scene.physics.transfer, solver->bounds(), dt,
                                        scene.physics.transfer.keeps_residual())
                                 .mass /
                             largest_mass;
      const StepReport report = solver->step({0.0, 1.0}, state);
      EXPECT_EQ(report.plan.dt, dt);
      const bool compare = step < 3 || step % 10 == 9;
      const ParticleSet found = compare ? gathered(comm, solver->particles()) : ParticleSet();
      if (!comm.is_root()) continue;
      reference.step(dt);
      if (compare) last = difference(reference, found, scene.physics);
      EXPECT_LE(last.largest(), tolerance(scene.physics.transfer))
          << "step " << step << ": x " << last.x << ", v " << last.v << ", C " << last.C << ", J " << last.J << ", b "
          << last.b << ", tau " << last.tau << ", dissipation " << last.dissipation;
      EXPECT_EQ(report.bounds.totals.n_particles, static_cast<GlobalIndex>(reference.particles.size()));
    }
    if (comm.is_root()) {
      const auto flowed = [](const ReferenceParticle& p) { return p.dissipation > 0.0; };
      EXPECT_TRUE(std::any_of(reference.particles.begin(), reference.particles.end(), flowed)) << "the fluid should flow";
    }
  }
};

TEST_F(SolverReferenceTest, ContactWithFloorWallsAndCollider) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    expect_agreement(contact_scene(transfer), 50, PartitionMethod::ranges, false);
  }
}

// What the stages of the steps do to the kinetic energy, with momenta and impulses told apart in every transfer.
TEST_F(SolverReferenceTest, EnergiesOfTheStages) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    SolverScene scene = periodic_scene(transfer, {8, 8, 8}, {true, true, true});
    scene.physics.separate_energies = true;
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges, false));
    ReferenceMpm reference = reference_of(scene);
    const double inertia = transfer.affine() ? reference.second_moment() : 0.0;
    const auto of_particles = [&] {
      double sum = 0.0;
      for (const ReferenceParticle& p : reference.particles)
        sum += 0.5 * p.m * (p.v.squaredNorm() + inertia * p.C.squaredNorm());
      return sum;
    };
    TimeStepState state;
    double to_grid = 0.0, kicks = 0.0, from_grid = 0.0, largest = 0.0;
    for (int step = 0; step < 20; ++step) {
      solver->step({0.0, 1.0}, state);
      if (!comm.is_root()) continue;
      const double before = of_particles();
      reference.step(scene.physics.time_stepping.dt_fixed);
      double old_nodes = 0.0, nodes = 0.0;
      for (const ReferenceNode& node : reference.nodes) {
        old_nodes += 0.5 * node.m * node.v_old.squaredNorm();
        nodes += 0.5 * node.m * node.v.squaredNorm();
      }
      to_grid += before - old_nodes;
      kicks += nodes - old_nodes;
      from_grid += nodes - of_particles();
      largest = std::max(largest, before);
    }
    const EnergyTotals found = solver->energy_totals();
    if (!comm.is_root()) continue;
    EXPECT_NEAR(found.to_grid, to_grid, 1e-9 * largest);
    EXPECT_NEAR(found.kicks, kicks, 1e-9 * largest);
    EXPECT_NEAR(found.from_grid, from_grid, 1e-9 * largest);
    EXPECT_GT(to_grid, 1e-3 * largest);
    EXPECT_FALSE(found.combined);
  }
}

TEST_F(SolverReferenceTest, PeriodicBox) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    expect_agreement(periodic_scene(transfer, {12, 8, 8}, {true, true, true}), 50, PartitionMethod::uniform, false);
  }
}

TEST_F(SolverReferenceTest, PeriodicSlabOfOneTile) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    expect_agreement(periodic_scene(transfer, {16, 4, 12}, {true, true, false}), 50, PartitionMethod::ranges, false);
  }
}

TEST_F(SolverReferenceTest, ParticlesFarFromTheOwnersOfTheirNodes) {
  for (const TransferSettings& transfer : some_transfers()) {
    SCOPED_TRACE(describe(transfer));
    expect_agreement(contact_scene(transfer), 30, PartitionMethod::uniform, true);
    expect_agreement(periodic_scene(transfer, {12, 8, 8}, {true, true, true}), 30, PartitionMethod::uniform, true);
  }
}

}  // namespace
}  // namespace bulkley::solver_reference_mpi_test
