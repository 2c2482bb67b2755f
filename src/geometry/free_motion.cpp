#include "geometry/free_motion.hpp"

#include <algorithm>
#include <cmath>

namespace bulkley {

namespace {

constexpr int most_sweeps = 50;
constexpr double largest_contraction = 0.25;

/// One step of the rotation: Pi_1 = Pi_0 + dt Pi_m x w, w = I^-1 Pi_m by fixed point, then Cayley's map.
void turn(const Vec3& inverse_moments, double dt, RigidState& state) {
  const Vec3 start = state.rotation.conjugate() * state.angular_momentum;
  Vec3 end = start, spin = Vec3::Zero();
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    const Vec3 middle = 0.5 * (start + end);
    spin = inverse_moments.cwiseProduct(middle);
    const Vec3 next = start + dt * middle.cross(spin);
    if (next == end) break;
    end = next;
  }
  const Vec3 half = 0.5 * dt * spin;
  state.rotation = (state.rotation * Eigen::Quaterniond(1.0, half[0], half[1], half[2])).normalized();
}

}  // namespace

Mat3 world_inertia(const RigidMass& mass, const RigidState& state) {
  const Mat3 r = state.rotation.toRotationMatrix();
  return r * mass.moments.asDiagonal() * r.transpose();
}

RigidVelocity velocity(const RigidMass& mass, const RigidState& state) {
  const Vec3 body = state.rotation.conjugate() * state.angular_momentum;
  return {state.momentum / mass.mass, state.rotation * body.cwiseQuotient(mass.moments), state.center};
}

double kinetic_energy(const RigidMass& mass, const RigidState& state) {
  const Vec3 body = state.rotation.conjugate() * state.angular_momentum;
  return 0.5 * (state.momentum.squaredNorm() / mass.mass + body.cwiseProduct(body).cwiseQuotient(mass.moments).sum());
}

RigidVelocity unit_velocity(const Guide& guide, const RigidState& state) {
  if (!guide.point) return {guide.direction, Vec3::Zero(), state.center};
  return {guide.direction.cross(state.center - *guide.point), guide.direction, state.center};
}

void set_rate(const RigidMass& mass, const Guide& guide, double rate, RigidState& state) {
  const RigidVelocity unit = unit_velocity(guide, state);
  state.momentum = mass.mass * rate * unit.velocity;
  state.angular_momentum = rate * (world_inertia(mass, state) * unit.angular_velocity);
}

double rate_of(const RigidMass& mass, const Guide& guide, const RigidState& state) {
  const RigidVelocity unit = unit_velocity(guide, state);
  const double inertia = mass.mass * unit.velocity.squaredNorm() +
                         unit.angular_velocity.dot(world_inertia(mass, state) * unit.angular_velocity);
  return (unit.velocity.dot(state.momentum) + unit.angular_velocity.dot(state.angular_momentum)) / inertia;
}

void advance(const RigidMass& mass, const std::optional<Guide>& guide, double dt, RigidState& state) {
  if (guide && guide->point) {
    const double rate = rate_of(mass, *guide, state), angle = dt * rate;
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(angle, guide->direction));
    state.center = *guide->point + turned * (state.center - *guide->point);
    state.rotation = (turned * state.rotation).normalized();
    state.turn += angle;
    set_rate(mass, *guide, rate, state);
    return;
  }
  state.center += dt * (state.momentum / mass.mass);
  if (guide) return;
  const Vec3 inverse = mass.moments.cwiseInverse();
  const double smallest = mass.moments.minCoeff(), largest = mass.moments.maxCoeff();
  const double contraction = std::abs(dt) * (state.angular_momentum.norm() / smallest) * (largest - smallest) / smallest;
  if (!std::isfinite(contraction)) return;  // the caller ends such a run
  int n_steps = 1;
  for (double rest = contraction; rest > largest_contraction && n_steps < (1 << 20); rest *= 0.5) n_steps *= 2;
  for (int n = 0; n < n_steps; ++n) turn(inverse, dt / n_steps, state);
}

}  // namespace bulkley
