// ranks: 1 2 3 4 8
// The real solver: the same bits on any number of ranks, under any partition, after rejected steps and through a restart;
// and failures that every rank reports alike.
#include "integrator/solver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "integrator/diagnostics.hpp"
#include "support/solver_run.hpp"

namespace bulkley::solver_mpi_test {
namespace {

class SolverTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  Comm self{MPI_COMM_SELF};

  // Runs `n_steps` and returns all particles at the end.
  static ParticleSet run(const Comm& on, const SolverScene& scene, Partition partition, int n_steps) {
    const auto solver = solver_of(on, scene, std::move(partition));
    TimeStepState state;
    for (int step = 0; step < n_steps; ++step) solver->step({0.0, 1.0}, state);
    return gathered(on, solver->particles());
  }

  // The sentence of the RunError that `work` ends with; empty if none. The same on every rank, or the test fails.
  template <class Work>
  std::string sentence(Work work) {
    std::string text;
    try {
      work();
    } catch (const RunError& error) {
      text = error.what();
    }
    EXPECT_EQ(text, broadcast_text(comm, text)) << "ranks disagree";
    return text;
  }
};

SolverScene shearing_scene(const TransferSettings& transfer, double rate) {
  SolverScene scene = empty_scene(transfer, {8, 8, 8}, {false, false, false});
  const Vec3 lower = scene.physics.grid.lower;
  add_block(scene, lower + Vec3(0.2, 0.2, 0.2), {6, 6, 6}, 1, Vec3::Zero());
  for (LocalIndex p = 0; p < scene.particles.size(); ++p) {
    const double height = scene.particles.real(Field::position, 2)[p] - lower[2] - 0.35;
    scene.particles.set_vector(Field::velocity, p, Vec3(rate * height, 0.0, 0.0));
    scene.particles.real(Field::affine_velocity, 2)[p] = rate;
  }
  scene.physics.time_stepping.mode = TimeStepMode::adaptive;
  return scene;
}

// --- the same bits ---------------------------------------------------------------------------------------------------

TEST_F(SolverTest, ParticlesAreTheSameOnAnyNumberOfRanksUnderAnyPartition) {
  for (const TransferSettings& transfer : some_transfers())
    for (const bool periodic : {false, true}) {
      SCOPED_TRACE(describe(transfer) + (periodic ? " periodic" : " contact"));
      SolverScene scene = periodic ? periodic_scene(transfer, {12, 8, 8}, {true, true, true}) : contact_scene(transfer);
      scene.physics.time_stepping = {};  // adaptive
      const ParticleSet alone = run(self, scene, partition_of(self, scene, PartitionMethod::ranges), 40);
      EXPECT_EQ(alone.size(), scene.particles.size());
      EXPECT_TRUE(same_particles(alone, run(comm, scene, partition_of(comm, scene, PartitionMethod::ranges), 40)));
      EXPECT_TRUE(same_particles(alone, run(comm, scene, partition_of(comm, scene, PartitionMethod::uniform), 40)));
      EXPECT_TRUE(same_particles(alone, run(comm, scene, partition_of(comm, scene, PartitionMethod::uniform, true), 40)));
    }
}

// Every law with its internal variables, which travel with the particles; and on from what a checkpoint would hold.
TEST_F(SolverTest, AllLawsSideBySideAreTheSameOnAnyNumberOfRanksAndThroughARestart) {
  for (const TransferSettings& transfer : {some_transfers()[0], some_transfers()[2], some_transfers()[4]}) {
    SCOPED_TRACE(describe(transfer));
    SolverScene scene = every_law_scene(transfer);
    scene.physics.time_stepping = {};
    constexpr int n_steps = 40;
    const ParticleSet alone = run(self, scene, partition_of(self, scene, PartitionMethod::ranges), n_steps);
    EXPECT_EQ(alone.size(), scene.particles.size());
    EXPECT_TRUE(same_particles(alone, run(comm, scene, partition_of(comm, scene, PartitionMethod::ranges), n_steps)));
    EXPECT_TRUE(same_particles(alone, run(comm, scene, partition_of(comm, scene, PartitionMethod::uniform, true), n_steps)));

    // Each law has deformed, and each internal variable has changed somewhere.
    for (const Field field :
         {Field::structure, Field::hardening, Field::plastic_volume_ratio, Field::viscous_left_cauchy_green}) {
      double change = 0.0;
      for (LocalIndex p = 0; p < alone.size(); ++p) {
        EXPECT_EQ(alone.id()[p], scene.particles.id()[p]);
        change = std::max(change, std::abs(alone.real(field)[p] - scene.particles.real(field)[p]));
      }
      EXPECT_GT(change, 1e-4) << info(field).name;
    }

    TimeStepState state;
    auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
    for (int step = 0; step < n_steps / 2; ++step) solver->step({0.0, 1.0}, state);
    const ParticleSet saved = gathered(comm, solver->particles());
    Solver restarted(comm, scene.physics, partition_of(comm, scene, PartitionMethod::uniform, true),
                     share_of(comm, saved, fields_of(scene.physics)), solver->bounds());
    for (int step = n_steps / 2; step < n_steps; ++step) restarted.step({0.0, 1.0}, state);
    EXPECT_TRUE(same_particles(alone, gathered(comm, restarted.particles())));
  }
}

// One block in one corner: with many ranks most of them have no particle and no pool.
TEST_F(SolverTest, RanksWithoutParticlesTakePart) {
  SolverScene scene = empty_scene(some_transfers()[0], {8, 8, 8}, {false, false, false});
  add_block(scene, scene.physics.grid.lower + Vec3(0.2, 0.2, 0.2), {2, 2, 2}, 0,
            Vec3(2.0, 2.0, 2.0));  // crosses from tile to tile
  const ParticleSet alone = run(self, scene, partition_of(self, scene, PartitionMethod::uniform), 150);
  EXPECT_TRUE(same_particles(alone, run(comm, scene, partition_of(comm, scene, PartitionMethod::uniform), 150)));
  EXPECT_GT(alone.real(Field::position)[0], scene.physics.grid.lower[0] + 0.45) << "it should have left its first tile";

  scene.particles.resize(0);
  scene.physics.time_stepping.mode = TimeStepMode::adaptive;
  scene.physics.time_stepping.dt_max = 1e-3;
  EXPECT_EQ(run(comm, scene, partition_of(comm, scene, PartitionMethod::uniform), 3).size(), 0);
}

TEST_F(SolverTest, BoundsAndPlansAreTheSameOnAnyNumberOfRanks) {
  SolverScene scene = contact_scene(some_transfers()[0]);
  scene.physics.time_stepping = {};
  const auto alone = solver_of(self, scene, partition_of(self, scene, PartitionMethod::ranges));
  const auto shared = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
  TimeStepState state_alone, state_shared;
  for (int step = 0; step < 20; ++step) {
    const StepReport a = alone->step({0.0, 1.0}, state_alone);
    const StepReport b = shared->step({0.0, 1.0, comm.rank() == comm.size() - 1 ? step : 0}, state_shared);
    EXPECT_EQ(a.plan.dt, b.plan.dt);
    EXPECT_EQ(a.plan.limiter, b.plan.limiter);
    EXPECT_EQ(a.plan.id, b.plan.id);
    EXPECT_EQ(a.bounds.motion.speed.value, b.bounds.motion.speed.value);
    EXPECT_EQ(a.bounds.motion.speed.id, b.bounds.motion.speed.id);
    EXPECT_EQ(a.bounds.motion.wave_speed.value, b.bounds.motion.wave_speed.value);
    EXPECT_EQ(a.bounds.motion.wave_speed.id, b.bounds.motion.wave_speed.id);
    EXPECT_EQ(a.bounds.motion.velocity_gradient.value, b.bounds.motion.velocity_gradient.value);
    EXPECT_EQ(a.bounds.motion.velocity_gradient.id, b.bounds.motion.velocity_gradient.id);
    EXPECT_EQ(a.bounds.sums.momentum, b.bounds.sums.momentum);
    EXPECT_EQ(a.bounds.sums.stress_volume, b.bounds.sums.stress_volume);
    EXPECT_EQ(a.bounds.sums.cell_count, b.bounds.sums.cell_count);
    EXPECT_EQ(a.bounds.totals.smallest_volume_ratio, b.bounds.totals.smallest_volume_ratio);
    EXPECT_EQ(a.bounds.totals.largest_volume_ratio, b.bounds.totals.largest_volume_ratio);
    EXPECT_EQ(b.bounds.totals.n_particles, scene.particles.size());
    EXPECT_EQ(b.bounds.requests.caller, step) << "one rank's request reaches all";
  }
}

TEST_F(SolverTest, ARestartedRunContinuesWithTheSameBits) {
  for (const TransferSettings& transfer : some_transfers()) {
    SCOPED_TRACE(describe(transfer));
    SolverScene scene = contact_scene(transfer);
    scene.physics.time_stepping = {};
    TimeStepState state;
    auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
    for (int step = 0; step < 15; ++step) solver->step({0.0, 1.0}, state);

    // What a checkpoint keeps: the particles without what lives within one step, the bounds, the controller.
    const ParticleSet saved = gathered(comm, solver->particles());
    const StepBounds bounds = solver->bounds();
    TimeStepState state_restarted = state;
    Solver restarted(comm, scene.physics, partition_of(comm, scene, PartitionMethod::uniform, true),
                     share_of(comm, saved, fields_of(scene.physics)), bounds);

    for (int step = 0; step < 15; ++step) {
      const StepReport a = solver->step({0.0, 1.0}, state), b = restarted.step({0.0, 1.0}, state_restarted);
      EXPECT_EQ(a.plan.dt, b.plan.dt);
    }
    EXPECT_TRUE(same_particles(gathered(comm, solver->particles()), gathered(comm, restarted.particles())));
  }
}

// --- rejected steps --------------------------------------------------------------------------------------------------

// T12 (iii): an absurd first step is halved until the shear allows it; the run is then that of the step that was accepted.
TEST_F(SolverTest, RejectedStepsLeaveNoTraceInTheParticles) {
  for (const TransferSettings& transfer : some_transfers()) {
    SCOPED_TRACE(describe(transfer));
    SolverScene absurd = shearing_scene(transfer, 100.0);
    absurd.physics.time_stepping.elastic_cfl = 1.0;
    absurd.physics.time_stepping.deformation_limit = 0.01;
    if (!transfer.affine())  // only the affine matrix would tell the first plan of the shear
      for (int c = 0; c < 9; ++c)
        std::fill_n(absurd.particles.real(Field::affine_velocity, c), absurd.particles.size(), 0.0);
    else
      for (int c = 0; c < 9; ++c)
        for (LocalIndex p = 0; p < absurd.particles.size(); ++p) absurd.particles.real(Field::affine_velocity, c)[p] *= 0.05;
    absurd.physics.time_stepping.dt_initial = 1.0;  // the other limits bring it to milliseconds
    const Partition partition = partition_of(comm, absurd, PartitionMethod::ranges);

    const auto rejecting = solver_of(comm, absurd, partition);
    TimeStepState state;
    const StepReport first = rejecting->step({0.0, 1.0}, state);
    EXPECT_GE(first.n_rejected, 2);
    EXPECT_EQ(state.n_rejected, first.n_rejected);
    EXPECT_LE(first.plan.dt * first.bounds.motion.velocity_gradient.value, 0.01);

    SolverScene accepted = contact_scene(transfer);
    accepted.physics = absurd.physics;
    accepted.particles = share_of(self, absurd.particles, {});
    accepted.physics.time_stepping.dt_initial = first.plan.dt;
    const auto direct = solver_of(comm, accepted, partition);
    TimeStepState state_direct;
    EXPECT_EQ(direct->step({0.0, 1.0}, state_direct).n_rejected, 0);
    EXPECT_TRUE(same_particles(gathered(comm, rejecting->particles()), gathered(comm, direct->particles())));
    for (int step = 0; step < 20; ++step) {
      rejecting->step({0.0, 1.0}, state);
      direct->step({0.0, 1.0}, state_direct);
    }
    EXPECT_TRUE(same_particles(gathered(comm, rejecting->particles()), gathered(comm, direct->particles())));
  }
}

// Trials and their rejections along a whole run: a second run is handed the accepted steps, and never judges one.
TEST_F(SolverTest, TheRunIsThatOfItsAcceptedSteps) {
  for (const TransferSettings& transfer : some_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SolverScene scene = judged_scene(transfer);
    const Partition partition = partition_of(comm, scene, PartitionMethod::ranges);
    const auto judged = solver_of(comm, scene, partition);
    TimeStepState state;
    std::vector<double> steps;
    for (int step = 0; step < 60; ++step) steps.push_back(judged->step({0.0, 1.0}, state).plan.dt);
    EXPECT_GT(state.n_rejected, 0);
    EXPECT_GT(state.n_accepted, 0);

    SolverScene replay = contact_scene(transfer);
    take_handed_steps(replay.physics);
    const auto handed = solver_of(comm, replay, partition);
    TimeStepState state_handed;
    for (const double dt : steps) EXPECT_EQ(handed->step({0.0, dt}, state_handed).plan.dt, dt);
    EXPECT_EQ(state_handed.n_rejected, 0);
    EXPECT_TRUE(same_particles(gathered(comm, judged->particles()), gathered(comm, handed->particles())));
  }
}

// T12 (iv): where the steps fall does not matter beyond their length: a free elastic block ends with the same momentum and, to
// first order in dt, the same energies under the controller (which starts at a tenth of its limit) as under a fixed step.
TEST_F(SolverTest, AdaptiveAndFixedStepsAgreeToFirstOrder) {
  const double end = 0.05;
  const auto run = [&](TimeStepMode mode, double elastic_cfl) {
    SolverScene scene = empty_scene({.scheme = TransferScheme::apic}, {12, 12, 12}, {false, false, false});
    add_block(scene, scene.physics.grid.lower + Vec3(0.3, 0.3, 0.3), {12, 12, 12}, 0, Vec3(0.3, -0.2, 0.1));
    TimeStepSettings& time = scene.physics.time_stepping;
    time.mode = mode;
    time.elastic_cfl = elastic_cfl;
    time.dt_fixed = elastic_cfl * 0.1 / 12.0;  // a little below the adaptive limit: c = 11.8 m/s at rest
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
    TimeStepState state;
    for (double t = 0.0; t < end;) {
      const StepReport report = solver->step({0.0, end - t}, state);
      t = report.plan.lands ? end : t + report.plan.dt;
    }
    const Physics& physics = scene.physics;
    return diagnose(comm, physics, solver->particles());
  };
  double difference[2];
  for (int k = 0; k < 2; ++k) {
    const double elastic_cfl = k == 0 ? 0.4 : 0.2;
    const Diagnostics adaptive = run(TimeStepMode::adaptive, elastic_cfl), fixed = run(TimeStepMode::fixed, elastic_cfl);
    const double energy = fixed.kinetic_energy + fixed.elastic_energy;
    EXPECT_LE((adaptive.momentum - fixed.momentum).norm(), 1e-12 * fixed.mass);
    difference[k] = std::abs(adaptive.kinetic_energy + adaptive.elastic_energy - energy) / energy;
    EXPECT_GT(difference[k], 0.0);
  }
  EXPECT_LE(difference[0], 1e-4);
  EXPECT_NEAR(difference[1] / difference[0], 0.5, 0.1);  // half the step, half the difference
}

TEST_F(SolverTest, TooSmallASmallestStepEndsTheRunAlikeOnEveryRank) {
  SolverScene scene = shearing_scene(some_transfers()[0], 100.0);
  scene.physics.time_stepping.dt_initial = 5e-4;
  scene.physics.time_stepping.dt_min = 4e-4;
  scene.physics.time_stepping.deformation_limit = 1e-3;
  for (int c = 0; c < 9; ++c) std::fill_n(scene.particles.real(Field::affine_velocity, c), scene.particles.size(), 0.0);
  scene.physics.transfer.scheme = TransferScheme::pic;
  const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
  TimeStepState state;
  const std::string text = sentence([&] { solver->step({0.0, 1.0}, state); });
  EXPECT_EQ(text.find("the time step would fall below its smallest value of 0.0004 s: even that step deforms a particle by "
                      "more than 0.001: particle "),
            0u)
      << text;
}

// --- the acceleration field ------------------------------------------------------------------------------------------

Vec3 mean_velocity(const ParticleSet& particles) {  // of particles of one mass
  Vec3 sum = Vec3::Zero();
  for (LocalIndex p = 0; p < particles.size(); ++p) sum += particles.vector(Field::velocity, p);
  return sum / particles.size();
}

TEST_F(SolverTest, AnAccelerationFieldMovesParticlesTheSameOnAnyNumberOfRanks) {
  for (const TransferScheme scheme : {TransferScheme::apic, TransferScheme::flip}) {
    TransferSettings transfer = some_transfers()[0];
    transfer.scheme = scheme;
    SolverScene scene = empty_scene(transfer, {8, 8, 8}, {false, false, false});
    scene.physics.gravity = Vec3(0.0, 0.0, -1.0);
    scene.physics.acceleration_field.text = {"3 + t", "0", "1"};
    add_block(scene, scene.physics.grid.lower + Vec3(0.3, 0.3, 0.3), {4, 4, 4}, 1, Vec3::Zero());
    scene.physics.time_stepping.mode = TimeStepMode::fixed;
    scene.physics.time_stepping.dt_fixed = 1e-4;
    const auto alone = solver_of(self, scene, partition_of(self, scene, PartitionMethod::uniform));
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::uniform));
    TimeStepState state_alone, state;
    const Vec3 before = mean_velocity(scene.particles);
    double time = 0.5, gain = 0.0;
    for (int step = 0; step < 20; ++step) {
      solver->step({time, 1.0}, state);
      alone->step({time, 1.0}, state_alone);
      gain += 1e-4 * (3.0 + time);
      time += 1e-4;
    }
    const ParticleSet particles = gathered(comm, solver->particles());
    EXPECT_TRUE(same_particles(gathered(self, alone->particles()), particles));
    EXPECT_NEAR((mean_velocity(particles) - before - Vec3(gain, 0.0, 0.0)).norm(), 0.0, 1e-13);
  }
}

TEST_F(SolverTest, AnAccelerationWithoutAValueIsTheSameErrorOnEveryRank) {
  for (const bool adaptive : {false, true}) {
    SolverScene scene = empty_scene(some_transfers()[0], {8, 8, 8}, {false, false, false});
    add_block(scene, scene.physics.grid.lower + Vec3(0.3, 0.3, 0.3), {4, 4, 4}, 1, Vec3::Zero());
    scene.physics.acceleration_field.text = {"t < 1 ? 0 : sqrt(-1)", "0", "0"};
    scene.physics.time_stepping.mode = adaptive ? TimeStepMode::adaptive : TimeStepMode::fixed;
    scene.physics.time_stepping.dt_fixed = 1e-4;
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::uniform));
    TimeStepState state;
    solver->step({0.5, 1.0}, state);
    const std::string text = sentence([&] { solver->step({1.0, 1.0}, state); });
    EXPECT_EQ(text.find("the acceleration_field is NaN or infinite on "), 0u) << text;
    EXPECT_NE(text.find(" nodes, first at ("), std::string::npos) << text;
  }
}

// --- particles that leave --------------------------------------------------------------------------------------------

TEST_F(SolverTest, OutflowRemovesAndCounts) {
  SolverScene scene = empty_scene(some_transfers()[0], {8, 8, 8}, {false, false, false});
  scene.physics.faces[1].kind = FaceKind::outflow;
  const Vec3 lower = scene.physics.grid.lower;
  add_block(scene, lower + Vec3(0.5, 0.2, 0.2), {6, 4, 4}, 0, Vec3(5.0, 0.0, 0.0));  // up to the face
  add_block(scene, lower + Vec3(0.1, 0.2, 0.2), {2, 4, 4}, 0, Vec3::Zero());
  const auto alone = solver_of(self, scene, partition_of(self, scene, PartitionMethod::uniform));
  const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::uniform));
  TimeStepState state_alone, state;
  GlobalIndex n_removed = 0;
  for (int step = 0; step < 150; ++step) {
    const StepReport report = solver->step({0.0, 1.0}, state);
    EXPECT_EQ(alone->step({0.0, 1.0}, state_alone).bounds.transport.n_removed, report.bounds.transport.n_removed);
    n_removed += report.bounds.transport.n_removed;
    EXPECT_EQ(report.bounds.totals.n_particles, scene.particles.size() - n_removed);
  }
  EXPECT_EQ(n_removed, 96);
  EXPECT_TRUE(same_particles(gathered(self, alone->particles()), gathered(comm, solver->particles())));
}

TEST_F(SolverTest, AnEscapeIsTheSameErrorOnEveryRank) {
  SolverScene scene = empty_scene(some_transfers()[0], {8, 8, 8}, {false, false, false});
  scene.physics.faces[3].kind = FaceKind::open;
  const Vec3 lower = scene.physics.grid.lower;
  add_block(scene, lower, {3, 3, 3}, 0, Vec3::Zero());
  add_particle(scene, Vec3(0.1, scene.physics.grid.upper()[1] - 1e-4, 0.5), Vec3(0.0, 2.0, 0.0));
  for (const PartitionMethod method : {PartitionMethod::uniform, PartitionMethod::ranges}) {
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, method));
    TimeStepState state;
    EXPECT_EQ(
        sentence([&] {
          solver->step({0.0, 1.0}, state);
        }),
        "1 particle left the domain through a face that is no outflow; the first is particle 27 of material 'solid' at "
        "(0.1, 1.0019, 0.5) m with speed 2 m/s and J = 1; let this face of [boundaries] be a wall or an outflow, or make "
        "the "
        "domain larger");
  }
}

TEST_F(SolverTest, AStartOutsideTheDomainIsAnError) {
  SolverScene scene = empty_scene(some_transfers()[0], {8, 8, 8}, {false, false, false});
  add_block(scene, scene.physics.grid.lower, {3, 3, 3}, 0, Vec3::Zero());
  const Partition partition = partition_of(comm, scene, PartitionMethod::uniform);
  add_particle(scene, Vec3(0.1, 5.0, 0.5));
  const std::string expected =
      "1 particle left the domain through a face that is no outflow; the first is particle 27 of material 'solid' at (0.1, "
      "5, 0.5) m "
      "with speed 0 m/s and J = 1; let this face of [boundaries] be a wall or an outflow, or make the domain larger";
  EXPECT_EQ(sentence([&] { solver_of(comm, scene, partition); }), expected);
  EXPECT_EQ(sentence([&] {
              Solver(comm, scene.physics, partition, share_of(comm, scene.particles, {}),
                     StepBounds{});  // as a restart does
            }),
            expected);
}

TEST_F(SolverTest, AParticleThatIsNotFiniteIsNamedAndCountedOnce) {
  for (const Field field : {Field::left_cauchy_green, Field::velocity}) {
    SolverScene scene = empty_scene(some_transfers()[0], {8, 8, 8}, {false, false, false});
    add_block(scene, scene.physics.grid.lower, {3, 3, 3}, 0, Vec3::Zero());
    add_particle(scene, scene.physics.grid.upper() - Vec3(0.1, 0.1, 0.1));  // far from all others
    const Partition partition = partition_of(comm, scene, PartitionMethod::uniform);
    scene.particles.real(field, 2)[27] = std::numeric_limits<double>::quiet_NaN();
    const std::string text = sentence([&] {
      const auto solver = solver_of(comm, scene, partition);
      TimeStepState state;
      solver->step({0.0, 1.0}, state);
    });
    EXPECT_EQ(text.substr(0, 59), "1 particle became NaN or infinite; the first is particle 27") << text;
  }
}

// --- what else the solver gives --------------------------------------------------------------------------------------

TEST_F(SolverTest, AVelocityThatIsNotFiniteIsNamedWhenTheStepIsJudged) {
  SolverScene scene = empty_scene({}, {8, 8, 8}, {false, false, false});
  scene.physics.time_stepping.mode = TimeStepMode::adaptive;
  add_particle(scene, Vec3(0.1, 0.6, 0.5));
  add_particle(scene, Vec3(-0.2, 0.3, 0.2), Vec3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0));  // far from the other
  const std::string text = sentence([&] {
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
    TimeStepState state;
    solver->step({0.0, 1.0}, state);
  });
  EXPECT_NE(text.find("1 particle became NaN or infinite; the first is particle 1 "), std::string::npos) << text;
}

TEST_F(SolverTest, NodeValuesChangeNothingAndHoldAllMass) {
  for (const TransferSettings& transfer : some_transfers()) {
    const SolverScene scene = contact_scene(transfer);
    const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
    TimeStepState state;
    for (int step = 0; step < 3; ++step) solver->step({0.0, 1.0}, state);
    const ParticleSet before = gathered(comm, solver->particles());
    const std::vector<Node> values = solver->node_values(0.0);
    EXPECT_TRUE(same_particles(before, gathered(comm, solver->particles())));
    double masses = 0.0;
    for (const Node& node : values) masses += node.c[3];
    BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, &masses, 1, MPI_DOUBLE, MPI_SUM, comm.get()));
    double total = 0.0;
    for (LocalIndex p = 0; p < before.size(); ++p) total += before.mass(p);
    EXPECT_NEAR(masses, total, 1e-12 * total);
  }
}

TEST_F(SolverTest, DiagnosticsAreTheSameOnAnyNumberOfRanks) {
  const SolverScene scene = contact_scene(some_transfers()[0]);
  const Physics& physics = scene.physics;
  const auto solver = solver_of(comm, scene, partition_of(comm, scene, PartitionMethod::ranges));
  TimeStepState state;
  for (int step = 0; step < 20; ++step) solver->step({0.0, 1.0}, state);
  const ParticleSet all = gathered(comm, solver->particles());
  const auto diagnosed = [&](const Comm& on, const ParticleSet& particles) { return diagnose(on, physics, particles); };
  const Diagnostics shared = diagnosed(comm, solver->particles()), alone = diagnosed(self, all);
  EXPECT_EQ(shared.mass, alone.mass);
  EXPECT_EQ(shared.momentum, alone.momentum);
  EXPECT_EQ(shared.angular_momentum, alone.angular_momentum);
  EXPECT_EQ(shared.kinetic_energy, alone.kinetic_energy);
  EXPECT_EQ(shared.elastic_energy, alone.elastic_energy);
  EXPECT_EQ(shared.gravitational_energy, alone.gravitational_energy);
  EXPECT_EQ(shared.dissipated_energy, alone.dissipated_energy);
  EXPECT_EQ(shared.center_of_mass, alone.center_of_mass);
  EXPECT_EQ(shared.lower, alone.lower);
  EXPECT_EQ(shared.upper, alone.upper);
  EXPECT_EQ(shared.yielded_fraction, alone.yielded_fraction);
  EXPECT_EQ(shared.n_particles, all.size());

  double mass = 0.0, kinetic = 0.0;
  Vec3 momentum = Vec3::Zero();
  const double second_moment =
      physics.grid.cell_size * physics.grid.cell_size / (physics.grid.order == SplineOrder::quadratic ? 4.0 : 3.0);
  for (LocalIndex p = 0; p < all.size(); ++p) {
    const Vec3 v = all.vector(Field::velocity, p);
    mass += all.mass(p);
    momentum += all.mass(p) * v;
    const double affine = physics.transfer.affine() ? tensor(all, Field::affine_velocity, p).squaredNorm() : 0.0;
    kinetic += 0.5 * all.mass(p) * (v.squaredNorm() + second_moment * affine);
  }
  EXPECT_NEAR(shared.mass, mass, 1e-13 * mass);
  EXPECT_LE((shared.momentum - momentum).norm(), 1e-13 * mass);
  EXPECT_NEAR(shared.kinetic_energy, kinetic, 1e-13 * kinetic);
  EXPECT_GT(shared.elastic_energy, 0.0);
  EXPECT_GT(shared.dissipated_energy, 0.0);
}

}  // namespace
}  // namespace bulkley::solver_mpi_test
