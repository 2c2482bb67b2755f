// ranks: 1 2 3 5 What a second integrator and a second node force find: transport that knows no scheme, forces with a state
// that a checkpoint keeps.
#include "integrator/integrator.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "integrator/describe_failure.hpp"
#include "integrator/explicit_step.hpp"
#include "integrator/solver.hpp"
#include "rebalance/share.hpp"
#include "simulation/simulation_state.hpp"
#include "support/solver_run.hpp"

namespace bulkley::integrator_mpi_test {
namespace {

// Particles that fly freely, without a grid: x += dt (v + dt g / 2), v += dt g.
class Ballistic : public Integrator {
 public:
  explicit Ballistic(StepParts& parts) : parts_(parts) {}

  StepReport step(const StepRequest& request, TimeStepState& state) override {
    parts_.fit();
    ParticleGrid& grid = parts_.particles;
    StepReport report;
    report.plan =
        plan_step(parts_.physics.time_stepping, grid.grid().cell_size, grid.bounds(), 0.0, request.remaining, state);
    const double dt = report.plan.dt;
    StepBounds local;
    grid.begin_move();
    ParticleSet& particles = grid.particles();
    for (LocalIndex first = 0; first < particles.size(); first += 256) {
      for (LocalIndex p = first; p < std::min<LocalIndex>(first + 256, particles.size()); ++p) {
        const Vec3 v = particles.vector(Field::velocity, p);
        particles.set_vector(Field::position, p,
                             particles.vector(Field::position, p) + dt * (v + 0.5 * dt * parts_.physics.gravity));
        particles.set_vector(Field::velocity, p, v + dt * parts_.physics.gravity);
        local.motion.speed.include(v.norm(), particles.id()[p]);
      }
      grid.place({first, first + 256});
    }
    local.requests.caller.include(request.from_rank);
    report.bounds = grid.finish_move(local);
    accept_step(parts_.physics.time_stepping, report.plan, report.bounds, state);
    return report;
  }
  void fit() override { parts_.fit(); }
  TimeStepLimit dt_limit(const StepBounds& bounds, double, double) const override {
    return time_step_limit(parts_.physics.time_stepping, parts_.physics.grid.cell_size, bounds, 0.0);
  }
  bool is_exact() const override { return true; }
  std::span<const Node> node_velocities(double) override { return {}; }
  int n_exchanges() const override { return 0; }
  std::size_t memory() const override { return 0; }

 private:
  StepParts& parts_;
};

// A wind that grows with every step taken: a force with a memory.
class GrowingWind : public NodeForce {
 public:
  const char* name() const override { return "growing_wind"; }
  void add(const ForcedNodes& nodes, FailureCounts&) override {
    for (const LocalIndex n : nodes.active)
      nodes.impulses[n].c[0] += nodes.update.dt * nodes.momenta[n].c[3] * strength_ * static_cast<double>(n_steps_);
  }
  void accept(double, double dt) override {
    ++n_steps_;
    strength_ += dt;
  }
  void save(Reals& reals, Integers& integers) const override {
    reals["strength"] = strength_;
    integers["n_steps"] = n_steps_;
  }
  void load(const Reals& reals, const Integers& integers) override {
    if (const auto found = reals.find("strength"); found != reals.end()) strength_ = found->second;
    if (const auto found = integers.find("n_steps"); found != integers.end()) n_steps_ = found->second;
  }
  GlobalIndex n_steps() const { return n_steps_; }

 private:
  double strength_ = 0.5;
  GlobalIndex n_steps_ = 0;
};

class IntegratorTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  Comm self{MPI_COMM_SELF};

  static Solver make(const Comm& on, const SolverScene& scene, const MakeIntegrator& make_integrator, NodeForces forces = {},
                     const ParticleSet* particles = nullptr, std::optional<StepBounds> bounds = std::nullopt) {
    return Solver(on, scene.physics, partition_of(on, scene, PartitionMethod::hilbert),
                  share_of(on, particles ? *particles : scene.particles, fields_of(scene.physics)), bounds,
                  std::move(forces), make_integrator);
  }
  static NodeForces wind() {
    NodeForces forces;
    forces.push_back(std::make_unique<GrowingWind>());
    return forces;
  }
};

void expect_same(const ParticleSet& a, const ParticleSet& b) {
  ASSERT_EQ(a.size(), b.size());
  for (LocalIndex p = 0; p < a.size(); ++p) {
    ASSERT_EQ(a.id()[p], b.id()[p]);
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(a.real(Field::position, c)[p], b.real(Field::position, c)[p]) << "particle " << a.id()[p];
      ASSERT_EQ(a.real(Field::velocity, c)[p], b.real(Field::velocity, c)[p]) << "particle " << a.id()[p];
    }
  }
}

TEST_F(IntegratorTest, ASchemeWithoutGridFindsItsTransport) {
  SolverScene scene = periodic_scene({}, {8, 8, 8}, {true, true, true});
  scene.physics.gravity = Vec3(1.0, -2.0, 0.5);
  const MakeIntegrator ballistic = [](StepParts& parts) { return std::make_unique<Ballistic>(parts); };
  Solver shared = make(comm, scene, ballistic);
  Solver alone = make(self, scene, ballistic);
  TimeStepState state, state_alone;
  GlobalIndex n_migrated = 0;
  constexpr int n_steps = 120;
  for (int step = 0; step < n_steps; ++step) {
    n_migrated += shared.step({1e-3 * step, 1.0}, state).bounds.transport.n_migrated;
    alone.step({1e-3 * step, 1.0}, state_alone);
    if (step == n_steps / 2) {  // under another map, too
      Partition scattered = partition_of(comm, scene, PartitionMethod::hilbert, true);
      shared.adopt(std::move(scattered));
    }
  }
  expect_same(gathered(comm, shared.particles()), gathered(self, alone.particles()));
  if (comm.size() > 1) {
    EXPECT_GT(n_migrated, 0);
  }
  // And what theory says of flight: v(t) = v(0) + g t.
  const ParticleSet end = gathered(comm, shared.particles());
  ASSERT_EQ(end.size(), scene.particles.size());
  const GlobalIndex* ids = scene.particles.id();
  const double t = 1e-3 * n_steps;
  for (LocalIndex p = 0; p < end.size(); ++p) {
    const auto at_start = static_cast<LocalIndex>(std::find(ids, ids + scene.particles.size(), end.id()[p]) - ids);
    const Vec3 expected = scene.particles.vector(Field::velocity, at_start) + t * scene.physics.gravity;
    EXPECT_LT((end.vector(Field::velocity, p) - expected).norm(), 1e-12);
  }
}

TEST_F(IntegratorTest, AForceWithAStateContinuesFromWhatACheckpointKeeps) {
  SolverScene scene = contact_scene({});
  scene.physics.time_stepping.mode = TimeStepMode::adaptive;
  scene.physics.time_stepping.dt_initial = 0.0;
  Solver whole = make(comm, scene, integrator_of, wind());
  Solver first = make(comm, scene, integrator_of, wind());
  TimeStepState state, state_first;
  constexpr int n_steps = 12;
  for (int step = 0; step < n_steps; ++step) whole.step({0.0, 1.0}, state);
  for (int step = 0; step < n_steps / 2; ++step) first.step({0.0, 1.0}, state_first);

  // Through the numbers of a checkpoint, as a run writes and reads them.
  SimulationState written;
  written.controller = state_first;
  written.bounds = first.bounds();
  first.save_forces(written.force_reals, written.force_integers);
  EXPECT_EQ(written.force_integers.at("force.growing_wind.n_steps"), n_steps / 2);
  Reals reals;
  Integers integers;
  save_state(written, reals, integers);
  SimulationState read = load_state(n_steps / 2, 0.0, reals, integers);
  const ParticleSet saved = gathered(comm, first.particles());
  const auto continued = [&](bool with_state) {
    Solver second = make(comm, scene, integrator_of, wind(), &saved, read.bounds);
    if (with_state) second.load_forces(read.force_reals, read.force_integers);
    TimeStepState controller = read.controller;
    for (int step = n_steps / 2; step < n_steps; ++step) second.step({0.0, 1.0}, controller);
    return gathered(comm, second.particles());
  };
  const ParticleSet expected = gathered(comm, whole.particles());
  expect_same(continued(true), expected);
  const ParticleSet forgotten = continued(false);
  double difference = 0.0;
  for (LocalIndex p = 0; p < forgotten.size(); ++p)
    difference = std::max(difference, (forgotten.vector(Field::velocity, p) - expected.vector(Field::velocity, p)).norm());
  EXPECT_GT(difference, 1e-6) << "the state matters";
}

TEST_F(IntegratorTest, RejectedStepsDoNotCountForAForce) {
  SolverScene scene = contact_scene({});
  scene.physics.time_stepping.mode = TimeStepMode::adaptive;
  scene.physics.time_stepping.deformation_check = DeformationCheck::always;
  scene.physics.time_stepping.deformation_limit = 0.005;
  NodeForces forces = wind();
  const auto& force = static_cast<const GrowingWind&>(*forces.front());
  Solver solver = make(comm, scene, integrator_of, std::move(forces));
  TimeStepState state;
  int n_rejected = 0;
  for (int step = 0; step < 40; ++step) n_rejected += solver.step({0.0, 1.0}, state).n_rejected;
  EXPECT_GT(n_rejected, 0);
  EXPECT_EQ(force.n_steps(), 40);
}

}  // namespace
}  // namespace bulkley::integrator_mpi_test
