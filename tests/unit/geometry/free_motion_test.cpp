#include "geometry/free_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bulkley::free_motion_test {
namespace {

const RigidMass top{2.0, Vec3(1.0, 2.0, 3.0)};

RigidState spinning(const Vec3& spin) {
  RigidState state;
  state.angular_momentum = top.moments.cwiseProduct(spin);
  return state;
}

Vec3 body_spin(const RigidState& state) {
  return Vec3(state.rotation.conjugate() * state.angular_momentum).cwiseQuotient(top.moments);
}

RigidState run(const Vec3& spin, double time, int n_steps) {
  RigidState state = spinning(spin);
  for (int n = 0; n < n_steps; ++n) advance(top, std::nullopt, time / n_steps, state);
  return state;
}

struct TopCase {
  Vec3 start;
  double time;
  Vec3 spin;
  Eigen::Vector4d rotation;  // w, x, y, z
};

// By Jacobi's elliptic functions, 12 digits.
const TopCase cases[] = {{Vec3(1.0, 0.0, 1.0),
                          1.0,
                          Vec3(0.577802471812, 0.816176637480, 0.882015815511),
                          {0.779039602588, 0.358209265957, 0.195829970695, 0.475850861047}},
                         {Vec3(1.0, 0.0, 1.0),
                          10.0,
                          Vec3(-0.921069998444, 0.389397044115, 0.974400660583),
                          {0.861441174065, 0.107340757620, 0.220947321794, -0.444498983542}},
                         {Vec3(1.0, 0.0, 1.0),
                          50.0,
                          Vec3(0.230483785932, 0.973076165787, 0.827269157243),
                          {-0.531178001839, -0.346202724106, -0.323865110242, -0.702214350858}},
                         {Vec3(0.1, 0.0, 1.0),
                          10.0,
                          Vec3(-0.084337738406, -0.053732168023, 0.999518693192),
                          {0.291173556329, -0.007713245674, 0.026079718919, -0.956283595068}},
                         {Vec3(0.01, 1.0, 0.01),
                          10.0,
                          Vec3(-0.874573437891, 0.484996187341, 0.505001220548),
                          {0.242702990920, 0.118144126725, -0.822720146747, -0.500268711449}}};

double spin_error(const TopCase& c, int n_steps) { return (body_spin(run(c.start, c.time, n_steps)) - c.spin).norm(); }

TEST(FreeMotion, EulersTopAgreesWithJacobi) {
  for (const TopCase& c : cases) {
    // Second order: of 2000 and 4000 steps a unit of time, extrapolated.
    const int n = static_cast<int>(2000.0 * c.time);
    const RigidState coarse = run(c.start, c.time, n), fine = run(c.start, c.time, 2 * n);
    const Vec3 spin = (4.0 * body_spin(fine) - body_spin(coarse)) / 3.0;
    EXPECT_LT((spin - c.spin).norm(), 2e-10) << c.time;
    const auto components = [](const Eigen::Quaterniond& q) { return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()); };
    const Eigen::Vector4d q = (4.0 * components(fine.rotation) - components(coarse.rotation)) / 3.0;
    EXPECT_LT(std::min((q - c.rotation).norm(), (q + c.rotation).norm()), 2e-10) << c.time;
    EXPECT_NEAR(spin_error(c, n) / spin_error(c, 2 * n), 4.0, 0.05);
  }
}

TEST(FreeMotion, EnergyAndMomentumToRounding) {
  for (const double dt : {0.001, 0.1, 2.0}) {
    RigidState state = spinning(Vec3(0.01, 1.0, 0.01));
    state.momentum = Vec3(1.0, 2.0, 3.0);
    const double energy = kinetic_energy(top, state);
    const Vec3 angular = state.angular_momentum;
    double largest = 0.0;
    for (int n = 0; n < 10000; ++n) {
      advance(top, std::nullopt, dt, state);
      largest = std::max(largest, std::abs(kinetic_energy(top, state) / energy - 1.0));
    }
    EXPECT_LT(largest, 1e-12) << dt;
    EXPECT_EQ(state.angular_momentum, angular);
  }
}

TEST(FreeMotion, GoesStraightAndBallsTurnEvenly) {
  const RigidMass ball{2.0, Vec3::Constant(0.5)};
  RigidState state;
  state.momentum = Vec3(2.0, 0.0, -4.0);
  state.angular_momentum = Vec3(0.0, 0.0, 0.25);
  advance(ball, std::nullopt, 0.5, state);
  EXPECT_TRUE(state.center.isApprox(Vec3(0.5, 0.0, -1.0), 1e-15));
  const double angle = 2.0 * std::atan(0.5 * 0.5 * 0.5);  // Cayley's map of the turn 0.25
  EXPECT_TRUE(state.rotation.isApprox(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitZ())), 1e-15));
  EXPECT_EQ(velocity(ball, state).at(state.center + Vec3::UnitX()), Vec3(1.0, 0.5, -2.0));
}

TEST(GuidedMotion, TurnsExactlyAboutItsAxis) {
  const Guide hinge{Vec3(1.0, 2.0, 2.0) / 3.0, Vec3(0.3, -0.2, 0.1)};
  RigidState start = spinning(Vec3::Zero());
  start.center = Vec3(0.5, 0.4, 0.2);
  set_rate(top, hinge, 1.5, start);
  EXPECT_NEAR(rate_of(top, hinge, start), 1.5, 1e-14);
  RigidState state = start;
  const int n_steps = 1000;
  const double turn = 2.0 * std::numbers::pi;
  for (int n = 0; n < n_steps; ++n) advance(top, hinge, turn / 1.5 / n_steps, state);
  EXPECT_LE((state.center - start.center).norm(), 1e-12);
  EXPECT_LE((state.momentum - start.momentum).norm(), 1e-11);
  EXPECT_LE(state.rotation.angularDistance(start.rotation), 1e-7);
  EXPECT_NEAR(state.turn, turn, 1e-12);
  EXPECT_NEAR(kinetic_energy(top, state), kinetic_energy(top, start), 1e-12);
}

TEST(GuidedMotion, KeepsWhatTheGuideLeavesOfMomenta) {
  const Guide line{Vec3(0.6, 0.0, 0.8), std::nullopt};
  RigidState state = spinning(Vec3(1.0, 2.0, 3.0));
  state.momentum = Vec3(3.0, 5.0, 4.0);
  EXPECT_NEAR(rate_of(top, line, state), 2.5, 1e-15);
  set_rate(top, line, 2.5, state);
  EXPECT_LE((state.momentum - Vec3(3.0, 0.0, 4.0)).norm(), 1e-15);
  EXPECT_EQ(state.angular_momentum, Vec3(Vec3::Zero()));
  advance(top, line, 2.0, state);
  EXPECT_LE((state.center - 2.0 * state.momentum / top.mass).norm(), 1e-15);
}

}  // namespace
}  // namespace bulkley::free_motion_test
