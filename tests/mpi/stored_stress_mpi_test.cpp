// ranks: 1 3
// Particles whose stress follows from their strain may store it, for frames.
#include <gtest/gtest.h>

#include <numeric>

#include "kernel/particle_stress.hpp"
#include "support/solver_run.hpp"

namespace bulkley::stored_stress_mpi_test {
namespace {

// The step takes the stress of the strain all the same, so that its bits do not depend on output.
TEST(StoredStress, ChangesNothing) {
  const Comm comm(PETSC_COMM_WORLD);
  for (const TransferSettings& transfer : {some_transfers()[0], some_transfers()[4]}) {
    SolverScene scene = contact_scene(transfer);
    scene.physics.time_stepping = {};  // adaptive
    const auto end_with = [&](OptionalFields fields) {
      Solver solver(comm, scene.physics, partition_of(comm, scene, PartitionMethod::ranges),
                    share_of(comm, scene.particles, fields), std::nullopt);
      TimeStepState state;
      for (int step = 0; step < 30; ++step) solver.step({0.0, 1.0}, state);
      return gathered(comm, solver.particles());
    };
    OptionalFields fields = fields_of(scene.physics);
    ASSERT_FALSE(fields.contains(Field::kirchhoff_stress));
    const ParticleSet bare = end_with(fields);
    fields.insert(Field::kirchhoff_stress);
    const ParticleSet stored = end_with(fields);
    std::vector<LocalIndex> order(static_cast<std::size_t>(stored.size()));
    std::iota(order.begin(), order.end(), 0);
    EXPECT_TRUE(same_particles(bare, picked(stored, order, bare.optional_fields())));
    const StressOfState none, of_state(scene.physics.materials);
    const ParticleStress expected(stored, none), found(bare, of_state);
    for (LocalIndex p = 0; p < bare.size(); ++p)
      for (int c = 0; c < 6; ++c) EXPECT_NEAR(found.of_one(p).c[c], expected.of_one(p).c[c], 1e-12 * 1e5);
  }
}

}  // namespace
}  // namespace bulkley::stored_stress_mpi_test
