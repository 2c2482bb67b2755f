#pragma once
// Momentum -> velocity on the nodes that a rank owns.

#include <span>

#include "grid/boundary.hpp"
#include "grid/contact_impulse.hpp"
#include "grid/node_pool.hpp"

namespace bulkley {

/// The velocity or momentum of a node. Not collective.
inline Vec3 vector_of(const Node& node) { return {node.c[0], node.c[1], node.c[2]}; }

/// Number of the face that a constraint by no collider is of: x lower, x upper, y lower, ... Not collective.
inline int face_of(const NodeConstraint& constraint) {
  int axis = 0;
  constraint.normal.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (constraint.normal[axis] > 0.0 ? 0 : 1);
}

struct GridUpdate {
  Vec3 gravity;          ///< m/s^2
  double dt;             ///< s
  double smallest_mass;  ///< kg; a node with no more counts as empty and gets zero velocity
  bool joined = false;   ///< nodes hold the impulses, too, where they are given apart (Impulses::both)
};

/// For every node of `active`: {m v + dt f, m} -> {v, m} with v = (m v + dt f) / m + dt g (T13).
/// With `impulse` (dt f apart, `nodes` holding m v, or m v + dt f with `update.joined`): also turns `impulse` into {v after - v before forces}; call
/// `apply_constraints` with both. Not collective.
void grid_update(const GridUpdate& update, std::span<const LocalIndex> active, Node* nodes, Node* impulse);

/// {m v + dt f, m} of the nodes behind walls -> added to their images in front, as the sum over the particles and their mirror
/// images would have it; nothing stays behind. With `impulse` (dt f apart, or in `nodes` as well): that too. Before grid_update. Not collective.
void fold_images(const GridUpdate& update, std::span<const NodeImage> images, Node* nodes, Node* impulse);

/// Impulses that have no part in gravity's, of nodes behind walls -> added to their images; none stay behind. Not collective.
void fold_impulses(std::span<const NodeImage> images, Node* impulses);

/// The velocities of the nodes behind walls from those in front, and their `change` where given. After apply_constraints.
/// Not collective.
void unfold_images(std::span<const NodeImage> images, Node* nodes, Node* change);

/// Applies contact to node velocities (constraint.node indexes `nodes`), and to `change` where given. Adds to `impulses` what
/// the colliders receive: mass x (velocity before - after) of every node. Not collective.
void apply_constraints(std::span<const NodeConstraint> constraints, Node* nodes, Node* change, ContactImpulses& impulses);

}  // namespace bulkley
