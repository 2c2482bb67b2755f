// Motion that is measured before a step is taken: that of the step, and as much of it as decides.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "support/reference_particles.hpp"
#include "support/serial_step.hpp"

namespace bulkley::measure_motion_test {
namespace {

TEST(MeasureMotion, MeasuredMotionIsThatOfTheStep) {
  for (TransferSettings transfer : all_transfers()) {
    transfer.affine_damping = 0.25;
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, random_particles(scene, 301, 16, true));
    run.particles_to_nodes(1e-3);
    run.update_nodes(1e-3);
    std::vector<LocalIndex> all(static_cast<std::size_t>(run.particles.size()));
    std::iota(all.begin(), all.end(), 0);
    const ParticleSet before = picked(run.particles, all);
    StepBounds motion;
    measure_motion(scene.grid, scene.transfer, run.layout, run.map, run.nodes.data(), run.particles, motion);
    EXPECT_TRUE(same_particles(run.particles, before));
    run.nodes_to_particles(1e-3);
    EXPECT_EQ(motion.motion.velocity_gradient.value, run.bounds.motion.velocity_gradient.value);
    EXPECT_EQ(motion.motion.velocity_gradient.id, run.bounds.motion.velocity_gradient.id);
    EXPECT_EQ(motion.failures.n_not_finite, 0);
    double fastest = 0.0;
    for (LocalIndex p = 0; p < before.size(); ++p)
      fastest =
          std::max(fastest, (run.particles.vector(Field::position, p) - before.vector(Field::position, p)).norm() / 1e-3);
    EXPECT_NEAR(motion.motion.speed.value, fastest, 1e-11 * fastest);

    StepBounds measured;
    measure_particles(scene.grid, scene.transfer, run.particles, measured);
    EXPECT_NEAR(measured.motion.speed.value, run.bounds.motion.speed.value, 1e-15 * measured.motion.speed.value);
    EXPECT_EQ(measured.motion.speed.id, run.bounds.motion.speed.id);
    EXPECT_NEAR(measured.sums.momentum, run.bounds.sums.momentum, 1e-15 * measured.sums.momentum);
    EXPECT_EQ(measured.sums.mass, run.bounds.sums.mass);
  }
}

// What exceeds ample limits is found by a measurement that leaves out what surely does not.
TEST(MeasureMotion, MeasuringWithAmpleLimitsMissesNothingAboveThem) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    const SerialScene scene = open_scene(transfer);
    SerialStep run(scene, random_particles(scene, 8000, 18, true));
    ASSERT_GT(run.particles.size() / 32, static_cast<LocalIndex>(run.layout.tiles().size()));
    run.particles_to_nodes(1e-3);
    run.update_nodes(1e-3);
    std::vector<NodePair> pairs(run.nodes.size());
    const auto measured = [&](const MotionLimits& ample) {
      StepBounds one, two;
      for (std::size_t n = 0; n < pairs.size(); ++n) pairs[n].motion = run.nodes[n];
      measure_motion(scene.grid, transfer, run.layout, run.map, run.nodes.data(), run.particles, one, ample);
      measure_motion(scene.grid, transfer, run.layout, run.map, pairs.data(), run.particles, two, ample);
      EXPECT_EQ(one.motion.velocity_gradient.id, two.motion.velocity_gradient.id);
      EXPECT_EQ(one.failures.n_not_finite, two.failures.n_not_finite);
      return one;
    };
    // Random motion in most of the box, linear motion with the gradient `rate` in the rest, so that some tiles are calm.
    const double rate = 5.0, middle = run.particles.vector(Field::position, 0)[0];
    for (std::size_t n = 0; n < run.nodes.size(); ++n) {
      const Vec3 x = run.node_position(n);
      if (x[0] > middle) continue;
      run.nodes[n].c[0] = rate * x[1] / std::sqrt(2.0);
      run.nodes[n].c[1] = -rate * x[0] / std::sqrt(2.0);
      run.nodes[n].c[2] = 0.0;
    }
    const MotionBounds whole = measured({}).motion;
    const double speed = whole.speed.value, gradient = whole.velocity_gradient.value;
    ASSERT_GT(gradient, 3.0 * rate);
    for (const double share : {0.01, 0.3, 0.6, 0.9, 0.99, 1.0 - 1e-9}) {
      const MotionBounds by_gradient = measured({2.0 * speed, share * gradient}).motion;
      EXPECT_EQ(by_gradient.velocity_gradient.value, gradient) << share;
      EXPECT_EQ(by_gradient.velocity_gradient.id, whole.velocity_gradient.id) << share;
      const MotionBounds by_speed = measured({share * speed, 100.0 * gradient}).motion;
      EXPECT_EQ(by_speed.speed.value, speed) << share;
      EXPECT_EQ(by_speed.speed.id, whole.speed.id) << share;
    }
    EXPECT_EQ(measured({100.0 * speed, 100.0 * gradient}).motion.velocity_gradient.id, -1);

    // For linear motion the bound is the gradient itself.
    for (std::size_t n = 0; n < run.nodes.size(); ++n) {
      const Vec3 x = run.node_position(n);
      for (int r = 0; r < 3; ++r) run.nodes[n].c[r] = r == 0 ? rate * (x[0] + x[1] + x[2]) / std::sqrt(3.0) : 0.0;
    }
    EXPECT_EQ(measured({1e6, rate * (1.0 + 1e-9)}).motion.velocity_gradient.id, -1);
    EXPECT_NEAR(measured({1e6, rate * (1.0 - 1e-9)}).motion.velocity_gradient.value, rate, 1e-9 * rate);

    run.nodes[run.nodes.size() / 2].c[1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(measured({1e6, 1e6}).failures.n_not_finite, measured({}).failures.n_not_finite);
  }
}

TEST(MeasureMotion, MotionThatIsNotFiniteIsCounted) {
  const SerialScene scene = open_scene({});
  SerialStep run(scene, random_particles(scene, 20, 17, false));
  run.particles_to_nodes(1e-3);
  run.update_nodes(1e-3);
  for (Node& node : run.nodes) node.c[1] = std::numeric_limits<double>::quiet_NaN();
  StepBounds motion;
  measure_motion(scene.grid, scene.transfer, run.layout, run.map, run.nodes.data(), run.particles, motion);
  EXPECT_EQ(motion.failures.n_not_finite, 20);
}

}  // namespace
}  // namespace bulkley::measure_motion_test
