#include "grid/rigid_collisions.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/mesh_shape.hpp"

namespace bulkley {

namespace {

constexpr std::size_t most_touches = 8;  // of a pair
constexpr int most_sweeps = 200;
constexpr double settled = 1e-15;     // last change of an impulse, over the largest
constexpr double slop = 0.01;         // cells that bodies may overlap
constexpr double push_share = 0.2;    // of the excess, in a step
constexpr double fastest_push = 0.5;  // cells in a step
constexpr double least_bounce = 2.0;  // approach over what forces change in the step: less is rest, not impact

Mat3 cross_matrix(const Vec3& r) {
  Mat3 m;
  m << 0.0, -r[2], r[1], r[2], 0.0, -r[0], -r[1], r[0], 0.0;
  return m;
}

bool overlap(const Bounds& box, const Vec3& center, double reach) {
  return (center.array() + reach >= box.lower.array()).all() && (center.array() - reach <= box.upper.array()).all();
}

}  // namespace

void RigidCollisions::Mover::push(const Vec3& arm, const Vec3& impulse) {
  if (freedom) {
    rate += inverse_of_freedom * (freedom->velocity.dot(impulse) + freedom->angular_velocity.dot(arm.cross(impulse)));
    velocity = rate * freedom->velocity;
    spin = rate * freedom->angular_velocity;
    return;
  }
  velocity += inverse_mass * impulse;
  spin += inverse_inertia * arm.cross(impulse);
}

Mat3 RigidCollisions::Mover::response(const Vec3& arm) const {
  if (freedom) {
    const Vec3 unit = freedom->velocity + freedom->angular_velocity.cross(arm);
    return inverse_of_freedom * unit * unit.transpose();
  }
  const Mat3 r = cross_matrix(arm);
  return inverse_mass * Mat3::Identity() - r * inverse_inertia * r;
}

std::vector<RigidCollisions::Mover> RigidCollisions::movers(const std::vector<RigidState>& states) const {
  std::vector<Mover> movers(states.size());
  for (std::size_t b = 0; b < states.size(); ++b) {
    const RigidMass& mass = starts_[b].mass;
    Mover& mover = movers[b];
    const RigidVelocity now = bulkley::velocity(mass, states[b]);
    mover.velocity = now.velocity;
    mover.spin = now.angular_velocity;
    mover.inverse_mass = 1.0 / mass.mass;
    const Mat3 turn = states[b].rotation.toRotationMatrix();
    mover.inverse_inertia = turn * mass.moments.cwiseInverse().asDiagonal() * turn.transpose();
    if (const auto& guide = starts_[b].guide) {
      const RigidVelocity unit = unit_velocity(*guide, states[b]);
      mover.freedom = unit;
      mover.rate = rate_of(mass, *guide, states[b]);
      mover.inverse_of_freedom = 1.0 / (mass.mass * unit.velocity.squaredNorm() +
                                        unit.angular_velocity.dot(world_inertia(mass, states[b]) * unit.angular_velocity));
    }
  }
  return movers;
}

Vec3 RigidCollisions::approach(const Touch& touch, const std::vector<Mover>& movers) const {
  const Vec3 own = movers[touch.body].at(touch.arm);
  return own - (touch.other ? movers[*touch.other].at(touch.other_arm) : touch.velocity);
}

// The deepest, then each time the one farthest from those taken: a body that lies flat rests on its corners.
void RigidCollisions::add_pair(std::vector<Touch>& found) {
  if (found.empty()) return;
  std::vector<double> away(found.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  for (std::size_t i = 1; i < found.size(); ++i)
    if (found[i].depth > found[next].depth) next = i;
  for (std::size_t n = 0; n < most_touches; ++n) {
    touches_.push_back(found[next]);
    const Vec3 taken = found[next].arm;
    for (std::size_t i = 0; i < found.size(); ++i) away[i] = std::min(away[i], (found[i].arm - taken).norm());
    next = static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin());
    if (!(away[next] > slop * grid_.cell_size)) return;
  }
}

void RigidCollisions::find_touches(double time, double dt, const std::vector<RigidState>& states) {
  touches_.clear();
  std::vector<Pose> poses;
  for (std::size_t b = 0; b < states.size(); ++b) poses.push_back(pose_of(starts_[b], states[b]));
  std::vector<Pose> collider_poses;
  std::vector<Bounds> collider_bounds;
  for (const Collider& collider : colliders_) {
    collider_poses.push_back(collider.motion.pose(time));
    collider_bounds.push_back(bounds(collider.shape, collider_poses.back()));
  }
  const Vec3 upper = grid_.upper();
  std::vector<Touch> found;
  for (std::size_t b = 0; b < states.size(); ++b) {
    const Vec3& center = states[b].center;
    const double reach = starts_[b].reach;
    // `shift`: from the body to where the other one sees it.
    const auto look = [&](const auto& distance_at, const auto& normal_at, const auto& add, const Vec3& shift) {
      for (const ContactPoint& rest : starts_[b].surface) {
        ContactPoint point = moved(rest, poses[b]);
        point.place += shift;
        const std::optional<Vec3> place = nearest_place(point, normal_at);
        if (!place) continue;
        if (const double distance = distance_at(*place); distance < 0.0) add(*place, -distance, normal_at(*place));
      }
    };
    for (std::size_t face = 0; face < faces_.size(); ++face) {
      const auto axis = static_cast<int>(face / 2);
      const bool is_lower = face % 2 == 0;
      if (!behaviour(faces_[face].kind).contact) continue;
      const double place = is_lower ? grid_.lower[axis] : upper[axis], sign = is_lower ? 1.0 : -1.0;
      if (sign * (center[axis] - place) > reach) continue;
      const Vec3 normal = sign * Vec3::Unit(axis);
      look([&](const Vec3& x) { return sign * (x[axis] - place); }, [&](const Vec3&) { return normal; },
           [&](const Vec3& x, double depth, const Vec3&) {
             found.push_back({b, std::nullopt, x - center, Vec3::Zero(), normal, depth, faces_[face].velocity});
           },
           Vec3::Zero());
      add_pair(found);
      found.clear();
    }
    for (std::size_t c = 0; c < colliders_.size(); ++c) {
      if (!overlap(collider_bounds[c], center, reach)) continue;
      const RigidVelocity motion = colliders_[c].motion.velocity_at(time + 0.5 * dt);
      look([&](const Vec3& x) { return signed_distance(colliders_[c].shape, collider_poses[c], x); },
           [&](const Vec3& x) { return outward_normal(colliders_[c].shape, collider_poses[c], x); },
           [&](const Vec3& x, double depth, const Vec3& normal) {
             found.push_back({b, std::nullopt, x - center, Vec3::Zero(), normal, depth, motion.at(x)});
           },
           Vec3::Zero());
      add_pair(found);
      found.clear();
    }
    for (std::size_t o = 0; o < states.size(); ++o) {
      if (o == b) continue;
      const Vec3 apart = nearest_arm(grid_, states[o].center, center);
      if (!(apart.norm() <= reach + starts_[o].reach)) continue;
      const Vec3 shift = states[o].center + apart - center;
      look([&](const Vec3& x) { return signed_distance(bodies_[o].shape, poses[o], x); },
           [&](const Vec3& x) { return outward_normal(bodies_[o].shape, poses[o], x); },
           [&](const Vec3& x, double depth, const Vec3& normal) {
             found.push_back({b, o, x - shift - center, x - states[o].center, normal, depth, Vec3::Zero()});
           },
           shift);
      add_pair(found);
      found.clear();
    }
  }
}

std::vector<Vec3> RigidCollisions::solve(const std::vector<double>& wanted, bool is_push, std::vector<Mover>& movers) const {
  struct Impulse {
    double normal_response, tangential_response;
    double normal = 0.0;
    Vec3 tangential = Vec3::Zero();
  };
  std::vector<Impulse> impulses;
  for (const Touch& touch : touches_) {
    Mat3 response = movers[touch.body].response(touch.arm);
    if (touch.other) response += movers[*touch.other].response(touch.other_arm);
    const double normal = touch.normal.dot(response * touch.normal);
    impulses.push_back({normal, response.trace() - normal});
  }
  const auto push = [&](const Touch& touch, const Vec3& impulse) {
    movers[touch.body].push(touch.arm, impulse);
    if (touch.other) movers[*touch.other].push(touch.other_arm, -impulse);
  };
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double largest = 0.0, change = 0.0;
    for (std::size_t k = 0; k < touches_.size(); ++k) {
      const Touch& touch = touches_[k];
      Impulse& impulse = impulses[k];
      if (!(impulse.normal_response > 0.0)) continue;  // its guide keeps the body from moving along the normal
      const Vec3 walls = is_push && !touch.other ? touch.velocity : Vec3(Vec3::Zero());
      const double missing = wanted[k] - touch.normal.dot(approach(touch, movers) + walls);
      const double normal = std::max(0.0, impulse.normal + missing / impulse.normal_response);
      push(touch, (normal - impulse.normal) * touch.normal);
      change = std::max(change, std::abs(normal - impulse.normal));
      impulse.normal = normal;
      largest = std::max(largest, normal);
      if (is_push || !(impulse.tangential_response > 0.0)) continue;
      const Vec3 sliding = approach(touch, movers);
      Vec3 tangential =
          impulse.tangential - (sliding - touch.normal.dot(sliding) * touch.normal) / impulse.tangential_response;
      const double friction = std::min(bodies_[touch.body].friction, touch.other ? bodies_[*touch.other].friction
                                                                                 : std::numeric_limits<double>::infinity());
      if (const double size = tangential.norm(); size > friction * normal) tangential *= friction * normal / size;
      push(touch, tangential - impulse.tangential);
      change = std::max(change, (tangential - impulse.tangential).norm());
      impulse.tangential = tangential;
    }
    if (!(change > settled * largest)) break;
  }
  std::vector<Vec3> result;
  for (std::size_t k = 0; k < touches_.size(); ++k)
    result.push_back(impulses[k].normal * touches_[k].normal + impulses[k].tangential);
  return result;
}

std::vector<CollisionEffect> RigidCollisions::collide(double time, double dt, const std::vector<RigidState>& before,
                                                      std::vector<RigidState>& states) {
  std::vector<CollisionEffect> effects(states.size());
  find_touches(time, dt, states);
  if (touches_.empty()) return effects;
  std::vector<Mover> now = movers(states);
  const std::vector<Mover> first = movers(before);
  std::vector<double> wanted;
  for (const Touch& touch : touches_) {
    const Vec3 relative = approach(touch, now);
    const double speed = -touch.normal.dot(relative), brought = (relative - approach(touch, first)).norm();
    const double restitution =
        std::min(bodies_[touch.body].restitution, touch.other ? bodies_[*touch.other].restitution : 1.0);
    wanted.push_back(speed > least_bounce * brought ? restitution * speed : 0.0);
  }
  const std::vector<Vec3> impulses = solve(wanted, false, now);
  for (std::size_t b = 0; b < states.size(); ++b) effects[b].work = -kinetic_energy(starts_[b].mass, states[b]);
  const auto give = [&](std::size_t body, const Vec3& arm, const Vec3& impulse) {
    effects[body].impulse += impulse;
    if (starts_[body].guide) return;
    states[body].momentum += impulse;
    states[body].angular_momentum += arm.cross(impulse);
  };
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    give(touches_[k].body, touches_[k].arm, impulses[k]);
    if (touches_[k].other) give(*touches_[k].other, touches_[k].other_arm, -impulses[k]);
  }
  for (std::size_t b = 0; b < states.size(); ++b) {
    if (const auto& guide = starts_[b].guide) set_rate(starts_[b].mass, *guide, now[b].rate, states[b]);
    effects[b].work += kinetic_energy(starts_[b].mass, states[b]);
  }
  return effects;
}

void RigidCollisions::push_out(double dt, std::vector<RigidState>& states, std::vector<CollisionEffect>& effects) const {
  const double dx = grid_.cell_size;
  std::vector<double> wanted;
  double most = 0.0;
  for (const Touch& touch : touches_) {
    wanted.push_back(std::clamp(push_share * (touch.depth - slop * dx), 0.0, fastest_push * dx) / dt);
    most = std::max(most, wanted.back());
  }
  if (!(most > 0.0)) return;
  std::vector<Mover> pushed = movers(states);
  for (Mover& mover : pushed) {
    mover.velocity = mover.spin = Vec3::Zero();
    mover.rate = 0.0;
  }
  solve(wanted, true, pushed);
  for (std::size_t b = 0; b < states.size(); ++b) {
    RigidState& state = states[b];
    if (const auto& guide = starts_[b].guide) {
      const double rate = rate_of(starts_[b].mass, *guide, state);
      set_rate(starts_[b].mass, *guide, pushed[b].rate, state);
      advance(starts_[b].mass, guide, dt, state);
      set_rate(starts_[b].mass, *guide, rate, state);
      continue;
    }
    state.center += dt * pushed[b].velocity;
    const double angle = dt * pushed[b].spin.norm();
    if (!(angle > 0.0)) continue;
    effects[b].work -= kinetic_energy(starts_[b].mass, state);
    state.rotation =
        (Eigen::Quaterniond(Eigen::AngleAxisd(angle, pushed[b].spin.normalized())) * state.rotation).normalized();
    effects[b].work += kinetic_energy(starts_[b].mass, state);
  }
}

}  // namespace bulkley
