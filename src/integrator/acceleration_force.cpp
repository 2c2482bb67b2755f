#include "integrator/acceleration_force.hpp"

namespace bulkley {

void AccelerationForce::add(const ForcedNodes& nodes, FailureCounts& failures) {
  for (std::size_t a = 0; a < nodes.active.size(); ++a) {
    const LocalIndex n = nodes.active[a];
    const double mass = nodes.momenta[n].c[3];
    if (!(mass > nodes.update.smallest_mass)) continue;
    const Int3& node = nodes.positions[a];
    const Vec3 gain = (mass * nodes.update.dt) * field_(grid_.node_position(node), nodes.time);
    for (int axis = 0; axis < 3; ++axis) nodes.impulses[n].c[axis] += gain[axis];
    if (gain.allFinite()) continue;
    ++failures.n_undefined_nodes;
    failures.undefined_node.include(grid_.node_number(node));
  }
}

}  // namespace bulkley
