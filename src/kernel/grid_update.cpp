#include "bulkley/kernel/grid_update.hpp"

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
      if (f) {
        f[a] = f[a] * inverse + fall[a];
        q[a] += f[a];
      } else {
        q[a] += fall[a];
      }
    }
  }
}

void apply_constraints(std::span<const NodeConstraint> constraints, Node* nodes, Node* change) {
  for (const NodeConstraint& constraint : constraints) {
    double* v = nodes[constraint.node].c;
    const Vec3 before(v[0], v[1], v[2]);
    const Vec3 after = constrained_velocity(constraint, before);
    for (int a = 0; a < 3; ++a) {
      v[a] = after[a];
      if (change) change[constraint.node].c[a] += after[a] - before[a];
    }
  }
}

}  // namespace bulkley
