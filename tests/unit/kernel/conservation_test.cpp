// What the transfers must keep (docs/theory.md, "Conservation"): statements C1 to C11, for every scheme, order and form.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "support/serial_step.hpp"

namespace bulkley::conservation_test {
namespace {

constexpr double dt = 1e-3;  // s

Vec3 xyz(const Node& node) { return {node.c[0], node.c[1], node.c[2]}; }

// Sums over particles or nodes, each with the sum of the absolute values as its scale.
struct Totals {
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  double momentum_scale = 0.0, angular_scale = 0.0;
};

Totals of_particles(const SerialStep& run) {
  Totals t;
  const ParticleSet& set = run.particles;
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const double m = set.mass(p);
    const Vec3 x = set.vector(Field::position, p), v = set.vector(Field::velocity, p);
    t.mass += m;
    t.momentum += m * v;
    t.angular += m * x.cross(v);
    if (run.scene.transfer.affine()) {
      const Mat3 B = tensor(set, Field::affine_velocity, p) * run.second_moment();
      t.angular += m * Vec3(B(2, 1) - B(1, 2), B(0, 2) - B(2, 0), B(1, 0) - B(0, 1));
    }
    t.momentum_scale += m * v.norm();
    t.angular_scale += m * x.norm() * v.norm();
  }
  return t;
}

// Of {m v, m}, before update_nodes.
Totals of_nodes(const SerialStep& run) {
  Totals t;
  for (std::size_t n = 0; n < run.nodes.size(); ++n) {
    const Vec3 q = xyz(run.nodes[n]), x = run.node_position(n);
    t.mass += run.nodes[n].c[3];
    t.momentum += q;
    t.angular += x.cross(q);
    t.momentum_scale += q.norm();
    t.angular_scale += x.norm() * q.norm();
  }
  return t;
}

// A cube of n^3 equal particles at rest, two per cell and axis, about the domain's centre.
ParticleSet cube(const SerialScene& scene, int n) {
  ParticleSet set(stressed_fields(scene.transfer.needs_velocity_gradient()), densities_of(scene.materials));
  set.resize(n * n * n);
  const double spacing = 0.5 * scene.grid.cell_size, volume = spacing * spacing * spacing;
  const Vec3 middle = 0.5 * (scene.grid.lower + scene.grid.upper());
  LocalIndex p = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k, ++p)
        place_particle(set, p, middle + spacing * (Vec3(i, j, k) - 0.5 * (n - 1) * Vec3::Ones()), volume);
  return set;
}

ParticleSet spinning_cube(const SerialScene& scene, int n, const Vec3& omega) {
  ParticleSet set = cube(scene, n);
  const Vec3 middle = 0.5 * (scene.grid.lower + scene.grid.upper());
  Mat3 spin;
  for (int a = 0; a < 3; ++a) spin.col(a) = omega.cross(Vec3::Unit(a));
  for (LocalIndex p = 0; p < set.size(); ++p) {
    set.set_vector(Field::velocity, p, omega.cross(set.vector(Field::position, p) - middle));
    set_tensor(set, Field::affine_velocity, p, spin);
  }
  return set;
}

// A cube of 6^3 particles off their lattice, with random velocities and affine matrices, and random stresses if asked.
ParticleSet agitated_cube(const SerialScene& scene, bool stressed) {
  ParticleSet set = cube(scene, 6);
  const ParticleSet random = random_particles(scene, set.size(), 21, stressed, 1.0);
  const Vec3 middle = 0.5 * (scene.grid.lower + scene.grid.upper());
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const Vec3 shift = 0.2 * scene.grid.cell_size * (random.vector(Field::position, p) - middle);
    set.set_vector(Field::position, p, set.vector(Field::position, p) + shift);
    set.set_vector(Field::velocity, p, random.vector(Field::velocity, p));
    for (int c = 0; c < 9; ++c) set.real(Field::affine_velocity, c)[p] = random.real(Field::affine_velocity, c)[p];
    for (int c = 0; c < 6; ++c) set.real(Field::kirchhoff_stress, c)[p] = random.real(Field::kirchhoff_stress, c)[p];
  }
  return set;
}

// Runs `check(run)` for each transfer, on an agitated cube.
template <class Check>
void for_each_transfer(bool stressed, Check check) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, agitated_cube(scene, stressed));
    check(run);
  }
}

TEST(Conservation, C1MassOfNodesIsThatOfParticles) {
  for_each_transfer(true, [](SerialStep& run) {
    run.particles_to_nodes(dt);
    EXPECT_NEAR(of_nodes(run).mass, of_particles(run).mass, 1e-14 * of_particles(run).mass);
  });
}

TEST(Conservation, C2MomentumSurvivesBothTransfers) {
  for_each_transfer(false, [](SerialStep& run) {
    const Totals before = of_particles(run);
    run.particles_to_nodes(dt);
    EXPECT_LE((of_nodes(run).momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    run.update_nodes(dt);
    run.nodes_to_particles(dt);
    EXPECT_LE((of_particles(run).momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
  });
}

// With particles at rest, what the nodes receive is the impulse of the internal forces alone.
TEST(Conservation, C3AndC4InternalForcesHaveNoSumAndNoMoment) {
  for_each_transfer(true, [](SerialStep& run) {
    for (LocalIndex p = 0; p < run.particles.size(); ++p) {
      run.particles.set_vector(Field::velocity, p, Vec3::Zero());
      set_tensor(run.particles, Field::affine_velocity, p, Mat3::Zero());
    }
    run.measure();
    run.particles_to_nodes(dt);
    if (run.split()) run.nodes = run.impulse;
    const Totals forces = of_nodes(run);
    EXPECT_GT(forces.momentum_scale, 0.0);
    EXPECT_LE(forces.momentum.norm(), 1e-13 * forces.momentum_scale);
    EXPECT_LE(forces.angular.norm(), 1e-12 * forces.angular_scale);
  });
}

TEST(Conservation, C5AngularMomentumOfNodesIsThatOfParticles) {
  for_each_transfer(false, [](SerialStep& run) {
    run.particles_to_nodes(dt);
    const Totals particles = of_particles(run);
    EXPECT_LE((of_nodes(run).angular - particles.angular).norm(), 1e-13 * particles.angular_scale);
  });
}

TEST(Conservation, C6ApicKeepsAngularMomentumInEveryStepAndOverTenThousand) {
  for (const TransferSettings& transfer : all_transfers()) {
    if (!transfer.affine()) continue;
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, spinning_cube(scene, 3, Vec3(1.0, -2.0, 4.0)));
    const Totals start = of_particles(run);
    Totals before = start;
    double largest_change = 0.0;
    for (int step = 0; step < 10000; ++step) {
      run.step(dt);
      const Totals after = of_particles(run);
      largest_change = std::max(largest_change, (after.angular - before.angular).norm());
      before = after;
    }
    // Rounding: moment_flip also works with differences of velocities before and after forces, large on nodes of little mass.
    const double tolerance = transfer.scheme == TransferScheme::moment_flip ? 2e-12 : 1e-12;
    EXPECT_LE(largest_change, tolerance * start.angular_scale);
    EXPECT_LE((before.angular - start.angular).norm(), 1e-10 * start.angular_scale);
    EXPECT_LE((before.momentum - start.momentum).norm(), 1e-10 * start.momentum_scale);
    EXPECT_GT(run.bounds.motion.velocity_gradient.value, 1.0) << "it should still spin";
  }
}

TEST(Conservation, C7PicLosesAngularMomentum) {
  for (const TransferSettings& transfer : all_transfers()) {
    if (transfer.scheme != TransferScheme::pic) continue;
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, spinning_cube(scene, 4, Vec3(1.0, -2.0, 4.0)));
    double last = of_particles(run).angular.norm();
    const double start = last;
    for (int step = 0; step < 5; ++step) {
      run.step(dt);
      const double now = of_particles(run).angular.norm();
      EXPECT_LT(now, last);
      last = now;
    }
    EXPECT_LT(last, 0.8 * start);
  }
}

TEST(Conservation, C8FlipKeepsAngularMomentumWithoutForces) {
  for_each_transfer(false, [](SerialStep& run) {
    if (run.scene.transfer.scheme != TransferScheme::flip) return;
    const Totals before = of_particles(run);
    run.step(dt);
    EXPECT_LE((of_particles(run).angular - before.angular).norm(), 1e-13 * before.angular_scale);
  });
}

// dL = -dt sum m_p sum w (x_i - x_p) x a_i + O(dt^2): halving dt quarters what the formula leaves.
TEST(Conservation, C8FlipDriftsWithForcesAsPredicted) {
  for (const TransferSettings& transfer : all_transfers()) {
    if (transfer.scheme != TransferScheme::flip) continue;
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    double drift = 0.0, unexplained[2];
    for (int half = 0; half < 2; ++half) {
      const double h = half ? 0.5 * dt : dt;
      SerialStep run(scene, agitated_cube(scene, true));
      const Totals before = of_particles(run);
      run.particles_to_nodes(h);
      run.update_nodes(h);
      // sum_i w (x_i - x_p) x a_i from B of the acceleration field: g2p of the change alone, with a transfer that returns B.
      SerialScene affine = scene;
      affine.transfer.scheme = TransferScheme::apic;
      affine.transfer.gradient = GradientForm::mls;
      SerialStep probe(affine, agitated_cube(affine, true));
      probe.nodes = run.impulse;
      probe.nodes_to_particles(h);
      Vec3 predicted = Vec3::Zero();
      for (LocalIndex p = 0; p < probe.particles.size(); ++p) {
        const Mat3 B = tensor(probe.particles, Field::affine_velocity, p) * run.second_moment();
        predicted -= probe.particles.mass(p) * Vec3(B(2, 1) - B(1, 2), B(0, 2) - B(2, 0), B(1, 0) - B(0, 1));
      }
      run.nodes_to_particles(h);
      const Vec3 change = of_particles(run).angular - before.angular;
      if (!half) drift = change.norm();
      unexplained[half] = (change - predicted).norm();
    }
    EXPECT_LT(unexplained[0], 0.2 * drift);
    EXPECT_NEAR(unexplained[1], 0.25 * unexplained[0], 0.02 * unexplained[0]);
  }
}

TEST(Conservation, C9FreeFallIsExact) {
  const Vec3 gravity(0.3, -1.0, -9.81), velocity(0.5, -0.25, 1.0);
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    SerialScene scene = open_scene(transfer);
    scene.gravity = gravity;
    const ParticleSet start = cube(scene, 4);
    ParticleSet set = cube(scene, 4);
    for (LocalIndex p = 0; p < set.size(); ++p) set.set_vector(Field::velocity, p, velocity);
    SerialStep run(scene, std::move(set));
    const int n = 100;
    for (int step = 0; step < n; ++step) run.step(dt);
    const Vec3 fall = n * dt * velocity + 0.5 * dt * dt * n * (n + 1) * gravity;
    for (LocalIndex p = 0; p < start.size(); ++p) {
      const Vec3 x = start.vector(Field::position, p) + fall;
      EXPECT_LE((run.particles.vector(Field::position, p) - x).norm(), 1e-12 * x.norm());
    }
  }
}

TEST(Conservation, C10TranslationChangesNoState) {
  const Vec3 velocity(0.5, -0.25, 1.0);
  for_each_transfer(false, [&](SerialStep& run) {
    for (LocalIndex p = 0; p < run.particles.size(); ++p) {
      run.particles.set_vector(Field::velocity, p, velocity);
      set_tensor(run.particles, Field::affine_velocity, p, Mat3::Zero());
    }
    run.measure();
    run.step(dt);
    for (LocalIndex p = 0; p < run.particles.size(); ++p) {
      EXPECT_LE((run.particles.vector(Field::velocity, p) - velocity).norm(), 1e-13 * velocity.norm());
      EXPECT_NEAR(run.particles.real(Field::volume_ratio)[p], 1.0, 1e-13);
      for (int c = 0; c < 6; ++c) EXPECT_NEAR(run.particles.real(Field::left_cauchy_green, c)[p], c < 3 ? 1.0 : 0.0, 1e-13);
      EXPECT_EQ(run.particles.real(Field::plastic_shear_rate)[p], 0.0);
    }
  });
}

TEST(Conservation, C11AffineFieldsAreReproduced) {
  Mat3 A;
  A << 1.0, 2.0, -0.5, 0.3, -1.5, 0.7, 0.9, -0.4, 0.6;
  const Vec3 offset(0.1, 0.2, -0.3);
  for_each_transfer(false, [&](SerialStep& run) {
    if (!run.scene.transfer.affine()) return;
    std::vector<Vec3> velocity;
    for (LocalIndex p = 0; p < run.particles.size(); ++p) {
      velocity.push_back(A * run.particles.vector(Field::position, p) + offset);
      run.particles.set_vector(Field::velocity, p, velocity.back());
      set_tensor(run.particles, Field::affine_velocity, p, A);
    }
    run.measure();
    run.particles_to_nodes(dt);
    run.update_nodes(dt);
    const double speed = run.bounds.motion.speed.value, of_velocity = 1e-12 * speed;
    const double of_gradient = of_velocity * inverse_second_moment(run.scene.transfer.order) / run.scene.grid.cell_size;
    for (std::size_t n = 0; n < run.nodes.size(); ++n)
      if (run.nodes[n].c[3] > run.bounds.sums.mass) {  // lighter nodes show the rounding of order-free sums, as 1 / m_i
        EXPECT_LE((xyz(run.nodes[n]) - A * run.node_position(n) - offset).norm(), of_velocity);
      }
    run.nodes_to_particles(dt);
    for (LocalIndex p = 0; p < run.particles.size(); ++p) {
      EXPECT_LE((run.particles.vector(Field::velocity, p) - velocity[static_cast<std::size_t>(p)]).norm(), of_velocity);
      EXPECT_LE((tensor(run.particles, Field::affine_velocity, p) - A).norm(), of_gradient);
    }
  });
}

}  // namespace
}  // namespace bulkley::conservation_test
