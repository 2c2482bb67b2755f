#pragma once
// What walls and colliders do to the kinetic energy of the nodes in one step (docs/theory.md, "Energy budget").

#include <span>
#include <vector>

#include "kernel/grid_update.hpp"

namespace bulkley {

/// Numbers of the places of contact: the six faces, then the colliders, then the rigid bodies.
constexpr std::size_t n_faces = 6;

/// Folds, contact and unfolding of one step, each done by the functions of kernel/grid_update.hpp and recorded. All numbers
/// are addends in J, of sums that their user forms.
class ContactAccount {
 public:
  explicit ContactAccount(std::size_t n_colliders) : places_(n_faces + n_colliders) {}

  /// Addends of one place of contact.
  struct Place {
    std::vector<double> energy;  ///< by which the contact changes the kinetic energy of the material
    std::vector<double> work;    ///< of it, done by the motion of the wall or collider; friction and impacts took the rest
  };

  /// Which share of their velocity particles keep, the rest being replaced by that of the nodes. Not collective.
  void set_kept_share(double share) { kept_share_ = share; }

  /// Forgets the step before. Not collective.
  void clear();

  /// fold_images, apply_constraints and unfold_images, in this order within a step. Not collective.
  void fold(const GridUpdate& update, std::span<const NodeImage> images, Node* nodes, Node* impulse);
  void apply(std::span<const NodeConstraint> constraints, Node* nodes, Node* change, ContactImpulses& received);
  void unfold(const GridUpdate& update, std::span<const NodeImage> images, Node* nodes, Node* change);

  const std::vector<Place>& places() const { return places_; }
  /// Added to minus the kinetic energy of the folded nodes before impulses, gives what the particles lost: minus that of all
  /// nodes, as the walls have turned them. Only where impulses are kept apart.
  const std::vector<double>& before() const { return before_; }
  /// Added to the kinetic energy of the folded nodes after contact, gives that of all nodes.
  const std::vector<double>& after() const { return after_; }
  /// Likewise: added to the work of the impulses along the motion before contact, gives their work along the mean motion of the step.
  const std::vector<double>& kicks() const { return kicks_; }
  /// Added to the work of gravity on the folded nodes, gives that on all nodes.
  const std::vector<double>& gravity() const { return gravity_; }

  std::size_t memory() const;

 private:
  /// A node behind a wall at its fold.
  struct Folded {
    double mass;    ///< kg
    Vec3 momentum;  ///< kg m/s; this and the next only at walls that move
    Vec3 given;     ///< kg m/s, to it and its image by the fold
  };
  Vec3 kick_of(LocalIndex node, const Node* change);

  double kept_share_ = 0.0;
  std::vector<Place> places_;
  std::vector<double> before_, after_, kicks_, gravity_;
  std::vector<Folded> behind_;      ///< by image
  std::vector<Vec3> kick_;          ///< m/s, velocity that the impulses gave to a node of `kicked_`
  std::vector<LocalIndex> kicked_;  ///< nodes that contact has touched in this step
  std::vector<LocalIndex> number_;  ///< by node: in `kicked_`, or -1
};

}  // namespace bulkley
