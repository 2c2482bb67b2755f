#pragma once
// What walls and colliders take from the owned nodes within the patches of gauges (docs/theory.md, "Gauges").
//
// Contact itself knows nothing of gauges: the constraints and images of the nodes within patches are carried out here once
// more, on copies of the nodes, and give the same bits.

#include <span>
#include <vector>

#include "grid/contact_impulse.hpp"
#include "integrator/physics.hpp"
#include "kernel/grid_update.hpp"

namespace bulkley {

/// Entries in ContactImpulses that gauges take, after those of the colliders: for each the impulse, then for each the part
/// that presses on the wall, as the first component.
inline std::size_t n_gauge_entries(const Physics& physics) { return 2 * physics.gauges.size(); }

class GaugeContact {
 public:
  /// `physics` must outlive this.
  explicit GaugeContact(const Physics& physics) : physics_(physics) {}

  /// The part of their own velocity that particles keep in a step: `a` of (T7). Not collective.
  void set_kept_share(double share) { kept_share_ = share; }

  /// For new pools. `nodes`: grid indices of the active nodes; `active`: their indices in the array of nodes, ascending, which
  /// `constraints` and `images` have too. Not collective.
  void fit(std::span<const NodeConstraint> constraints, std::span<const NodeImage> images, const std::vector<Int3>& nodes,
           std::span<const LocalIndex> active);

  /// Before fold_images, with its arguments. Not collective.
  void before_fold(const GridUpdate& update, const Node* nodes, const Node* impulse);
  /// Before apply_constraints with the constraints of `fit`. Not collective.
  void before_constraints(const Node* nodes, ContactImpulses& received) const;
  /// Before apply_constraints with those of colliders that move. Not collective.
  void before_moving(std::span<const NodeConstraint> constraints, double time, const Node* nodes,
                     ContactImpulses& received) const;
  /// After before_fold, of further impulses that are about to be folded. Not collective.
  void before_later_fold(const Node* impulses);
  /// After unfold_images. Not collective.
  void after_unfold(const Node* nodes, const Node* change, ContactImpulses& received) const;

  std::size_t memory() const;

 private:
  /// Shares first .. first + count - 1 of `shares_`.
  struct Range {
    std::uint32_t first = 0, count = 0;
  };
  struct Share {
    std::uint32_t gauge;
    double part;      ///< of the node's wall, 0 to 1
    Vec3 components;  ///< 1 for those of the impulse that the wall takes, 0 for the others
    Vec3 normal;      ///< out of the wall, into the material
  };
  struct WatchedConstraint {
    NodeConstraint constraint;
    Range shares;
  };
  struct WatchedImage {
    NodeImage image;    ///< its nodes in the caller's array
    NodeImage in_copy;  ///< and in `copy_`
    Range shares;       ///< none: only because a later one takes what it folds
  };
  /// What a node behind a wall has when it is folded.
  struct Behind {
    Vec3 momentum;  ///< after forces and gravity, kg m/s
    Vec3 impulse;   ///< of forces and gravity; only with forces apart
    double mass;
  };

  void fit_constraints(std::span<const NodeConstraint> constraints, const std::vector<Int3>& nodes,
                       std::span<const LocalIndex> active);
  void fit_images(std::span<const NodeImage> images, const std::vector<Int3>& nodes, std::span<const LocalIndex> active);
  void add_shares_on_face(FaceName face, const Vec3& components, const Int3& node);
  Range shares_on_faces(FaceName face, const Int3& node);
  Range shares_on_collider(const NodeConstraint& constraint);
  Range shares_of(const NodeConstraint& constraint) const;
  const Collider& collider_of(const Gauge& gauge) const {
    return physics_.colliders[static_cast<std::size_t>(gauge.collider_number)];
  }
  void add(const Share& share, const Vec3& impulse, ContactImpulses& received) const;

  const Physics& physics_;
  double kept_share_ = 0.0;
  std::vector<WatchedConstraint> constraints_;  ///< all of the nodes that have a share, in the order of the list
  std::vector<WatchedImage> images_;            ///< in the order in which they are folded
  std::vector<Share> shares_;
  std::vector<LocalIndex> copied_;  ///< the node that each of `copy_` is
  std::vector<Node> copy_, copied_impulse_;
  std::vector<Behind> behind_;  ///< of each of `images_`
};

}  // namespace bulkley
