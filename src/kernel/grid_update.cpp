#include "kernel/grid_update.hpp"

#include <algorithm>
#include <ranges>

namespace bulkley {

void grid_update(const GridUpdate& update, std::span<const LocalIndex> active, Node* nodes, Node* impulse) {
  const Vec3 fall = update.dt * update.gravity;
  for (const LocalIndex n : active) {
    double* q = nodes[n].c;
    const double mass = q[3];
    double* f = impulse ? impulse[n].c : nullptr;
    if (!(mass > update.smallest_mass)) {
      for (int a = 0; a < 3; ++a) {
        q[a] = 0.0;
        if (f) f[a] = 0.0;
      }
      continue;
    }
    const double inverse = 1.0 / mass;
    for (int a = 0; a < 3; ++a) {
      q[a] *= inverse;
      if (f) f[a] = f[a] * inverse + fall[a];
      q[a] += f && !update.joined ? f[a] : fall[a];
    }
  }
}

// grid_update gives the whole mass the acceleration of gravity. What is behind a wall falls as its image has it; the
// difference goes with the forces.
void fold_images(const GridUpdate& update, std::span<const NodeImage> images, Node* nodes, Node* impulse) {
  for (const NodeImage& image : images) {
    double* behind = nodes[image.behind].c;
    double* front = nodes[image.front].c;
    double* force = impulse ? impulse[image.front].c : front;
    const double mass = behind[3];
    for (int a = 0; a < 3; ++a) {
      const double sign = image.sign[a], opposite = 1.0 - sign;
      front[a] += sign * behind[a] + opposite * mass * image.velocity[a];
      if (impulse) force[a] += sign * impulse[image.behind].c[a];
      force[a] -= opposite * mass * update.dt * update.gravity[a];
      if (impulse && update.joined) front[a] -= opposite * mass * update.dt * update.gravity[a];
    }
    front[3] += mass;
    std::fill_n(behind, 4, 0.0);
    if (impulse) std::fill_n(impulse[image.behind].c, 4, 0.0);
  }
}

void fold_impulses(std::span<const NodeImage> images, Node* impulses) {
  for (const NodeImage& image : images)
    for (int a = 0; a < 3; ++a) {
      impulses[image.front].c[a] += image.sign[a] * impulses[image.behind].c[a];
      impulses[image.behind].c[a] = 0.0;
    }
}

void unfold_images(std::span<const NodeImage> images, Node* nodes, Node* change) {
  for (const NodeImage& image : std::views::reverse(images))
    for (int a = 0; a < 3; ++a) {
      const double sign = image.sign[a];
      nodes[image.behind].c[a] = sign * nodes[image.front].c[a] + (1.0 - sign) * image.velocity[a];
      if (change) change[image.behind].c[a] = sign * change[image.front].c[a];
    }
}

void apply_constraints(std::span<const NodeConstraint> constraints, Node* nodes, Node* change, ContactImpulses& impulses) {
  for (const NodeConstraint& constraint : constraints) {
    double* v = nodes[constraint.node].c;
    const Vec3 before(v[0], v[1], v[2]);
    const Vec3 after = constrained_velocity(constraint, before);
    for (int a = 0; a < 3; ++a) {
      v[a] = after[a];
      if (change) change[constraint.node].c[a] += after[a] - before[a];
    }
    if (constraint.collider >= 0 && v[3] > 0.0)
      impulses.add(static_cast<std::size_t>(constraint.collider), v[3] * (before - after), constraint.arm);
  }
}

}  // namespace bulkley
