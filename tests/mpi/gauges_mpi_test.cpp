// ranks: 1 2 3 7
// Gauges on patches of walls: together they take exactly the momentum that the material loses, on every kind of wall.
#include <gtest/gtest.h>

#include <cmath>

#include "integrator/diagnostics.hpp"
#include "support/solver_run.hpp"

namespace bulkley::gauges_mpi_test {
namespace {

constexpr int n_steps = 30;
constexpr double dt = 1e-3;

Gauge on_face(FaceName face) {
  Gauge gauge;
  gauge.face = face;
  return gauge;
}

Gauge on_collider(int number) {
  Gauge gauge;
  gauge.collider_number = number;
  return gauge;
}

void add_every_wall(Physics& physics) {
  for (int f = 0; f < 6; ++f)
    if (behaviour(physics.faces[static_cast<std::size_t>(f)].kind).contact)
      physics.gauges.push_back(on_face(static_cast<FaceName>(f)));
  for (std::size_t c = 0; c < physics.colliders.size(); ++c) physics.gauges.push_back(on_collider(static_cast<int>(c)));
}

// What a gauge received, and the part of it that presses.
struct Received {
  Vec3 impulse;
  double pressing;
};

// Those whose paths differ most, and one whose residual decays in time.
std::vector<TransferSettings> transfers() {
  std::vector<TransferSettings> result = some_transfers();
  result.push_back({.scheme = TransferScheme::moment_flip});
  return result;
}

class GaugesTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  Comm self{MPI_COMM_SELF};

  static Vec3 momentum(const Comm& on, const Solver& solver) {
    const Physics& p = solver.physics();
    return diagnose(on, p, solver.particles()).momentum;
  }

  static std::unique_ptr<Solver> started(const Comm& on, const SolverScene& scene) {
    return solver_of(on, scene, partition_of(on, scene, PartitionMethod::hilbert));
  }

  static void advance(Solver& solver, int steps) {
    TimeStepState state;
    for (int s = 0; s < steps; ++s) solver.step({s * dt, dt}, state);
  }

  static Received received(const Solver& solver, std::size_t gauge) {
    const ContactImpulses sums = solver.contact_impulses();
    const std::size_t first = solver.physics().colliders.size(), n = solver.physics().gauges.size();
    return {sums.impulse(first + gauge), sums.impulse(first + n + gauge)[0]};
  }

  // Momentum before + weight - what the walls received = momentum after.
  void expect_balance(const SolverScene& scene, const std::string& what, double rounding = 1e-11) {
    const auto solver = started(comm, scene);
    const Vec3 before = momentum(comm, *solver);
    const double mass = diagnose(comm, scene.physics, solver->particles()).mass;
    advance(*solver, n_steps);
    Vec3 taken = Vec3::Zero();
    double largest = 0.0;
    for (std::size_t g = 0; g < scene.physics.gauges.size(); ++g) {
      const Vec3 impulse = received(*solver, g).impulse;
      taken += impulse;
      largest = std::max(largest, impulse.norm());
    }
    EXPECT_GT(largest, 0.05 * before.norm()) << what << ": the walls take part";
    const Vec3 expected = before + n_steps * dt * mass * scene.physics.gravity - taken;
    EXPECT_LE((momentum(comm, *solver) - expected).norm(), rounding * largest) << what << ": to the rounding of nodal sums";
  }
};

// Sticky walls that move, slip walls, rough ones, a ball, edges and corners between them.
TEST_F(GaugesTest, WallsTakeTheMomentumThatTheMaterialLoses) {
  for (const TransferSettings& transfer : transfers()) {
    SolverScene scene = contact_scene(transfer);
    add_every_wall(scene.physics);
    expect_balance(scene, describe(transfer));
  }
}

TEST_F(GaugesTest, SoDoEdgesBetweenStickyWalls) {
  for (const TransferSettings& transfer : transfers()) {
    SolverScene scene = contact_scene(transfer);
    for (Face& face : scene.physics.faces) face = {FaceKind::sticky, 0.0, Vec3::Zero()};
    scene.physics.faces[3].velocity = Vec3(0.5, 0.0, -0.3);
    add_every_wall(scene.physics);
    expect_balance(scene, describe(transfer));
  }
}

TEST_F(GaugesTest, SoDoWallsOfASlab) {
  for (const TransferSettings& transfer : transfers()) {
    SolverScene scene = periodic_scene(transfer, {8, 4, 8}, {false, true, false});
    scene.physics.gravity = Vec3(0.0, 0.0, -9.81);
    add_every_wall(scene.physics);
    ASSERT_EQ(scene.physics.gauges.size(), 4u);
    expect_balance(scene, describe(transfer));
  }
}

// Two colliders that move and one at rest, where faces act on the same nodes.
TEST_F(GaugesTest, SoDoCollidersThatMove) {
  for (const TransferSettings& transfer : transfers()) {
    SolverScene scene = contact_scene(transfer);
    Collider& paddle = scene.physics.colliders.emplace_back();
    paddle.name = "paddle";
    paddle.shape = {Box{Vec3(-0.3, 0.25, 0.1), Vec3(0.0, 0.9, 0.3)}};
    paddle.contact = Contact::sticky;
    paddle.motion.velocity = Vec3(1.0, 0.0, 0.2);
    paddle.motion.angular_velocity = Vec3(0.0, 0.5, 0.0);
    settle_center(paddle);
    add_every_wall(scene.physics);
    expect_balance(scene, describe(transfer));
    const auto solver = started(comm, scene);
    advance(*solver, n_steps);
    const std::size_t n_faces = scene.physics.gauges.size() - 2;
    for (std::size_t c = 0; c < 2; ++c)
      EXPECT_EQ(received(*solver, n_faces + c).impulse, solver->contact_impulses().impulse(c))
          << "a gauge on all of a collider has the collider's own sums";
  }
}

// Pressures that walls and colliders take inside the pressure system are in their impulses.
TEST_F(GaugesTest, SoDoAllOfThemUnderAnImplicitPressure) {
  for (const TransferSettings& transfer : {some_transfers()[0], some_transfers()[3]}) {
    SolverScene scene = contact_scene(transfer);
    Collider& paddle = scene.physics.colliders.emplace_back();
    paddle.name = "paddle";
    paddle.shape = {Box{Vec3(-0.3, 0.25, 0.1), Vec3(0.0, 0.9, 0.3)}};
    paddle.contact = Contact::separating;
    paddle.friction = 0.3;
    paddle.motion.velocity = Vec3(1.0, 0.0, 0.2);
    settle_center(paddle);
    add_every_wall(scene.physics);
    make_implicit(scene.physics);
    expect_balance(scene, "implicit, " + describe(transfer), 1e-12);
    const auto together = started(comm, scene), alone = started(self, scene);
    advance(*together, n_steps);
    advance(*alone, n_steps);
    EXPECT_EQ(together->contact_impulses().words(), alone->contact_impulses().words()) << describe(transfer);
  }
}

// Patches that divide a wall have parts that add up to the whole.
TEST_F(GaugesTest, PatchesDivideAWall) {
  SolverScene scene = contact_scene(some_transfers()[0]);
  const Vec3 lower = scene.physics.grid.lower, upper = scene.physics.grid.upper();
  const double cut = lower[0] + 0.337;
  Gauge left = on_face(FaceName::z_lower), right = left;
  left.lower = right.lower = lower;
  left.upper = right.upper = upper;
  (*left.upper)[0] = (*right.lower)[0] = cut;
  scene.physics.gauges = {on_face(FaceName::z_lower), left, right};
  const auto solver = started(comm, scene);
  advance(*solver, n_steps);
  const Received whole = received(*solver, 0), one = received(*solver, 1), other = received(*solver, 2);
  EXPECT_LE((whole.impulse - one.impulse - other.impulse).norm(), 1e-13 * whole.impulse.norm());
  EXPECT_NEAR(whole.pressing, one.pressing + other.pressing, 1e-13 * whole.pressing);
  EXPECT_EQ(whole.pressing, -whole.impulse[2]);
  EXPECT_GT(one.pressing, 0.05 * whole.pressing);
  EXPECT_GT(other.pressing, 0.05 * whole.pressing);
}

TEST_F(GaugesTest, AreTheSameBitsOnAnyNumberOfRanks) {
  for (const TransferSettings& transfer : transfers()) {
    SolverScene scene = contact_scene(transfer);
    add_every_wall(scene.physics);
    Gauge disc = on_face(FaceName::z_lower);
    disc.center = Vec3(0.2, 0.6, 0.1);
    disc.radius = 0.17;
    scene.physics.gauges.push_back(disc);
    const auto together = started(comm, scene), alone = started(self, scene);
    advance(*together, n_steps);
    advance(*alone, n_steps);
    EXPECT_EQ(together->contact_impulses().words(), alone->contact_impulses().words()) << describe(transfer);
  }
}

// What measures must not change what it measures.
TEST_F(GaugesTest, LeaveTheRunAsItIs) {
  for (const TransferSettings& transfer : transfers()) {
    SolverScene scene = contact_scene(transfer), watched = contact_scene(transfer);
    add_every_wall(watched.physics);
    const auto plain = started(comm, scene), other = started(comm, watched);
    advance(*plain, n_steps);
    advance(*other, n_steps);
    EXPECT_TRUE(same_particles(gathered(comm, plain->particles()), gathered(comm, other->particles())))
        << describe(transfer);
  }
}

}  // namespace
}  // namespace bulkley::gauges_mpi_test
