#pragma once
// The nodes that the feeds of inflows hold (docs/theory.md, "Inflow").

#include <span>
#include <vector>

#include "grid/boundary.hpp"
#include "integrator/physics.hpp"

namespace bulkley {

class FeedNodes {
 public:
  /// `physics` must outlive this.
  explicit FeedNodes(const Physics& physics) : physics_(physics) {}

  /// `nodes[n]`: grid indices of the node at `places[n]` of the caller's array; `fixed`: constraints of walls and colliders that do not
  /// move, by place. Not collective.
  void fit(std::vector<Int3> nodes, std::vector<LocalIndex> places, std::span<const NodeConstraint> fixed);

  /// The constraints of the step from `time` to `time` + `dt`, to be applied after those of walls and colliders: sticky, where the feeds
  /// are at `time`, with the velocity of the middle of the step; numbered after the colliders. `stretches`:
  /// NozzleState::stretch by feed; `moving`: constraints of colliders that move. Not collective.
  std::vector<NodeConstraint> at(double time, double dt, std::span<const double> stretches,
                                 std::span<const NodeConstraint> moving) const;

  std::size_t memory() const;

 private:
  /// A node that a sticky collider holds.
  struct Walled {
    LocalIndex place;
    Vec3 velocity;  ///< of the wall there, m/s
  };
  static std::vector<Walled> walled_by(std::span<const NodeConstraint> constraints);

  const Physics& physics_;
  std::vector<Int3> nodes_;
  std::vector<LocalIndex> places_;
  std::vector<Walled> fixed_;  ///< by place
};

}  // namespace bulkley
