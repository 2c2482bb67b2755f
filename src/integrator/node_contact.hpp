#pragma once
// Walls and colliders on the owned nodes: what every integrator applies between forces and particles.

#include <optional>
#include <vector>

#include "distribution/particle_grid.hpp"
#include "integrator/contact_account.hpp"
#include "integrator/feed_nodes.hpp"
#include "integrator/gauge_contact.hpp"
#include "integrator/physics.hpp"
#include "integrator/rigid_contact.hpp"
#include "kernel/grid_update.hpp"

namespace bulkley {

/// No sums yet, in the units of these physics: of the colliders, then of the gauges (n_gauge_entries).
ContactImpulses no_contact_impulses(const Physics& physics);

class NodeContact {
 public:
  /// Both must outlive this.
  NodeContact(const Physics& physics, const Comm& comm);

  /// For gauges; see GaugeContact::set_kept_share. Not collective.
  void set_kept_share(double share) { gauges_.set_kept_share(share); }

  /// Finds the constraints of the nodes of new pools. Not collective.
  void fit(const Exchange& exchange);

  /// {m v + dt f, m} of nodes behind walls -> their images in front. Before the node update. `impulse`: as fold_images.
  /// `account`: what contact does to the energy, here and in `apply`. Not collective.
  void fold(const GridUpdate& update, Node* nodes, Node* impulse, ContactAccount& account) {
    gauges_.before_fold(update, nodes, update.joined ? nullptr : impulse);
    account.fold(update, images_, nodes, impulse);
  }
  /// Impulses that were found after `fold` and the node update, of nodes in front of walls and behind -> of those in front. Not
  /// collective.
  void fold_later(Node* impulses);
  /// Velocities -> velocities after contact in a step from `time`, and of the nodes behind walls. `change`: as
  /// apply_constraints; `stretches`: of the feeds, as FeedNodes::at. Adds what colliders and gauges receive to `received`. Collective
  /// where there are rigid bodies.
  void apply(double time, const GridUpdate& update, std::span<const double> stretches, Node* nodes, Node* change,
             ContactImpulses& received, ContactAccount& account);

  /// Speed that no point of a collider or rigid body exceeds between two times, m/s. Not collective.
  double collider_speed(double first, double last) const;

  /// No sums, in the right units; for `apply` and `add`.
  const ContactImpulses& no_impulses() const { return none_; }
  /// A step was taken in which the colliders of this rank's nodes received that.
  void add(const ContactImpulses& received) { impulses_.add(received); }
  /// What the material has given to the colliders since the start or the last `set_impulses`, over all ranks; the same bits
  /// on any number of ranks. Collective.
  ContactImpulses impulses(const Comm& comm) const;
  /// Continues from such sums: those of a checkpoint, or none. Not collective (the same on every rank).
  void set_impulses(const Comm& comm, const ContactImpulses& sums);

  /// The rigid bodies, if there are any; nullptr else.
  RigidContact* rigid_bodies() { return rigid_ ? &*rigid_ : nullptr; }
  const RigidContact* rigid_bodies() const { return rigid_ ? &*rigid_ : nullptr; }

  std::size_t memory() const;

 private:
  void merge_bodies(double time, const GridUpdate& update, std::span<const NodeConstraint> moving, Node* nodes, Node* change,
                    ContactImpulses& received, ContactAccount& account);

  const Physics& physics_;
  ContactImpulses none_, impulses_;
  std::vector<NodeConstraint> constraints_;
  std::optional<MovingConstraints> moving_constraints_;  ///< only where a collider moves
  std::vector<NodeImage> images_;
  GaugeContact gauges_;
  std::optional<RigidContact> rigid_;  ///< only where there are rigid bodies
  ContactImpulses rigid_received_;     ///< of no use: the bodies' own sums have it
  FeedNodes feeds_;
};

}  // namespace bulkley
