// ranks: 1 2 4
// Motion that is finite and still must not continue: the step ends with the particle's name, place and what to try, alike on
// every rank.
#include "stepping/failure.hpp"

#include <gtest/gtest.h>

#include <string>

#include "support/solver_run.hpp"

namespace bulkley::step_failure_mpi_test {
namespace {

struct Outcome {
  std::string text;
  std::optional<Vec3> place;
};

class StepFailureTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  // A block at rest, and a particle far from it that is the offender: id 27, at `place`. Its law stores the stress, which is zero
  // whatever its volume ratio, so that it does not move.
  SolverScene scene_with_offender() {
    SolverScene scene = empty_scene({}, {8, 8, 8}, {false, false, false});
    add_block(scene, scene.physics.grid.lower, {3, 3, 3}, 1, Vec3::Zero());
    add_particle(scene, place);
    scene.physics.materials[0].material = Hencky{{1000.0, 1e5, 3e4}};
    return scene;
  }

  // The failure that the first step of the scene ends with; the same on every rank, or the test fails.
  Outcome failure_of(const SolverScene& scene) {
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::uniform));
    TimeStepState state;
    Outcome outcome;
    try {
      solver->step({0.0, 1.0}, state);
    } catch (const StepFailure& failure) {
      outcome = {failure.what(), failure.place};
    }
    EXPECT_EQ(outcome.text, broadcast_text(comm, outcome.text)) << "ranks disagree";
    return outcome;
  }

  const Vec3 place{0.35, 0.85, 0.75};
};

TEST_F(StepFailureTest, ACrushedParticle) {
  SolverScene scene = scene_with_offender();
  scene.physics.time_stepping.smallest_volume_ratio = 0.05;
  scene.particles.real(Field::volume_ratio)[27] = 0.06;
  EXPECT_EQ(failure_of(scene).text, "");
  scene.particles.real(Field::volume_ratio)[27] = 0.04;
  const Outcome outcome = failure_of(scene);
  EXPECT_EQ(
      outcome.text,
      "material is crushed to less than 0.05 of its volume (time.smallest_volume_ratio): particle 27 of material 'solid' "
      "at (0.35, 0.85, 0.75) m with speed 0 m/s and J = 0.04; try a larger bulk_modulus, slower motion, or a smaller "
      "limit");
  ASSERT_TRUE(outcome.place);
  EXPECT_EQ(*outcome.place, place);
}

TEST_F(StepFailureTest, AParticleThatHasGrownBeyondAllBounds) {
  SolverScene scene = scene_with_offender();
  scene.physics.time_stepping.allow_unstable = true;  // so large a particle is stiff
  scene.physics.time_stepping.largest_volume_ratio = 50.0;
  scene.particles.real(Field::volume_ratio)[27] = 49.0;
  EXPECT_EQ(failure_of(scene).text, "");
  scene.particles.real(Field::volume_ratio)[27] = 51.0;
  EXPECT_EQ(failure_of(scene).text.substr(0, 108),
            "material has grown to more than 50 times its volume (time.largest_volume_ratio): particle 27 of material 'so");
}

TEST_F(StepFailureTest, AParticleThatMovesMoreThanACell) {
  SolverScene scene = scene_with_offender();
  scene.physics.time_stepping.allow_unstable = true;
  scene.physics.time_stepping.dt_fixed = 1e-3;
  scene.particles.set_vector(Field::velocity, 27, Vec3(-99.0, 0.0, 0.0));
  EXPECT_EQ(failure_of(scene).text, "");
  scene.particles.set_vector(Field::velocity, 27, Vec3(-120.0, 0.0, 0.0));
  const Outcome outcome = failure_of(scene);
  EXPECT_EQ(
      outcome.text,
      "a particle moves 1.2 cells in a step of 0.001 s: particle 27 of material 'solid' at (0.23, 0.85, 0.75) m with speed "
      "120 m/s and J = 1; try a smaller time.cfl or time.dt, or time.deformation_check = \"always\"");
}

TEST_F(StepFailureTest, AFixedStepThatHasBecomeTooLong) {
  SolverScene scene = scene_with_offender();
  scene.particles.set_vector(Field::velocity, 27, Vec3(-60.0, 0.0, 0.0));
  EXPECT_EQ(
      failure_of(scene).text,
      "the fixed time step of 0.001 s is above the speed limit of 0.000833333 s (particle 27): particle 27 of material "
      "'solid' at (0.35, 0.85, 0.75) m with speed 60 m/s and J = 1; choose a smaller time.dt, mode = \"adaptive\", or "
      "allow_unstable = true");
}

}  // namespace
}  // namespace bulkley::step_failure_mpi_test
