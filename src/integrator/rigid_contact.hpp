#pragma once
// Free rigid bodies among the material: in each step a body and the nodes that it holds are merged, one system of six equations a
// body from exact sums (docs/theory.md, "Rigid bodies"). Every rank has all bodies.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/named_numbers.hpp"
#include "distribution/particle_grid.hpp"
#include "grid/exact_sums.hpp"
#include "grid/rigid_collisions.hpp"
#include "integrator/merged_body.hpp"
#include "integrator/physics.hpp"
#include "kernel/grid_update.hpp"

namespace bulkley {

class RigidContact {
 public:
  /// Both must outlive this.
  RigidContact(const Physics& physics, const Comm& comm);

  /// Of new pools: grid indices of the active nodes, their places in the nodal arrays, and the constraints by what does not move, in
  /// those places. Not collective.
  void fit(std::vector<Int3> nodes, std::vector<LocalIndex> places, std::span<const NodeConstraint> walls);

  /// Finds the bodies' velocities after a step of update.dt from `time`, with nodes as walls have left them, {v, m}; `moving`: constraints
  /// of moving colliders. Changes no body and no node. Throws StepFailure, the same on every rank, if a force or torque of the scene has
  /// no value. Collective.
  void merge(double time, const GridUpdate& update, std::span<const NodeConstraint> moving, const Node* nodes);
  /// The parts of `merge`, for who solves for the motion of nodes and bodies together. What the body that is deepest at `x` would do to a
  /// node there, without its number and velocity; none where no body holds it. `poses`: those of `poses()`. Not collective.
  std::optional<NodeConstraint> held_at(const Vec3& x, std::span<const Pose> poses) const;
  /// Whether a body's surface is within `clearance` of `x`, or beyond it, m. `poses`: those of `poses()`. Not collective.
  bool any_within(double clearance, const Vec3& x, std::span<const Pose> poses) const;
  /// Sums of all bodies before any node; adds a node that one holds, {v, m}. Not collective.
  ExactSums no_sums() const;
  void add_node(const NodeConstraint& constraint, const Node& node, ExactSums& sums) const {
    add_node(constraint, share_in_contact(constraint), node, sums);
  }
  /// Each body with the nodes of such sums over all ranks. Throws as `merge`. Not collective.
  std::vector<MergedBody> merged(double time, const GridUpdate& update, const ExactSums& sums);
  /// As the bodies move now. Not collective.
  std::vector<RigidVelocity> velocities() const;
  /// Some body lets material go. Not collective.
  bool any_separates() const { return any_separates_; }
  std::size_t body_of(const NodeConstraint& constraint) const {
    return static_cast<std::size_t>(constraint.collider) - physics_.n_obstacles();
  }
  std::size_t n_bodies() const { return bodies_.size(); }
  /// The unit of lengths in a body's equations, m.
  double scale(std::size_t body) const { return starts_[body].reach; }

  /// After `merge`: what gives the held nodes their velocities, without nodes that separate; bodies are numbered after the colliders. Then the walls' share of those
  /// nodes again, for a body must not push material through a wall. Not collective.
  std::span<const NodeConstraint> held() const { return held_; }
  std::span<const NodeConstraint> walls_again() const { return again_; }

  /// The step of the last `merge` was taken and ends at `time`, s: the bodies collide and move. Throws StepFailure, the same on every
  /// rank, if one has left the domain or is pressed into something. Not collective (the same on every rank).
  void accept(double time, double dt);

  /// Speed that no point of a body exceeds within `duration`, s, but for contact, m/s. Not collective.
  double speed_bound(double duration) const;

  /// From where the scene puts each body to where it is. Not collective.
  std::vector<Pose> poses() const;
  /// Names and values of the columns of each body in history.csv. Forces are averaged over the time since `begin_history`.
  static std::vector<std::string> columns();
  std::vector<std::vector<double>> history() const;
  void begin_history();

  void save(Reals& reals) const;
  void load(const Reals& reals);
  std::size_t memory() const;

 private:
  /// What a body has gone through since the start, or since the row before.
  struct Account {
    Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();              ///< by the material, since the row before
    double duration = 0.0;                                                    ///< s, since the row before
    Vec3 collision_impulse = Vec3::Zero();                                    ///< since the row before
    Vec3 guide_impulse = Vec3::Zero(), guide_angular_impulse = Vec3::Zero();  ///< likewise, but for collisions
    double gravity_work = 0.0, applied_work = 0.0, merging_loss = 0.0;        ///< J, since the start
    double collision_work = 0.0;                                              ///< likewise
  };
  /// What the scene pushes a body with.
  struct Drive {
    std::optional<VectorField> force, torque;
  };
  /// The end of the step that is tried.
  struct Trial {
    Vec3 momentum, angular_momentum, impulse, angular_impulse;
    Vec3 guide_impulse = Vec3::Zero(), guide_angular_impulse = Vec3::Zero();
    double gravity_work, applied_work, merging_loss;
  };
  /// The state after gravity, the scene's force and torque, within the guide; and what these are, kg m/s and kg m^2/s, and do, J.
  struct Pushed {
    RigidState state;
    Vec3 impulse, angular_impulse;
    double gravity_work, applied_work;
  };
  /// Of a node's velocity relative to its body, what the body takes: of the part along the normal, and of the rest.
  struct Share {
    double normal, tangential;
  };
  static constexpr std::size_t n_sums = 27;  ///< lower triangle of a 6 x 6 matrix, row after row, then the right side

  /// Of a node that touches, without friction.
  static Share share_in_contact(const NodeConstraint& constraint) {
    return {1.0, constraint.contact == Contact::sticky ? 1.0 : 0.0};
  }
  void find_held(std::span<const NodeConstraint> moving, double smallest_mass, const Node* nodes);
  void find_walls_again(std::span<const NodeConstraint> moving);
  void add_node(const NodeConstraint& constraint, Share share, const Node& node, ExactSums& sums) const;
  Share share_of(const NodeConstraint& constraint, const Node& node, const std::vector<Vec6>& motions) const;
  Vec3 body_velocity(const NodeConstraint& constraint, const std::vector<Vec6>& motions) const;
  std::vector<Vec6> find_motions(const std::vector<Pushed>& pushed, double dt, const Node* nodes);
  void keep_contacts(const std::vector<Vec6>& motions, const Node* nodes);
  double reach(const RigidBody& body) const;
  double distance_within(double clearance, std::size_t body, const Vec3& x, const Pose& pose) const;
  Pushed pushed(std::size_t body, double time, const GridUpdate& update);
  MergedBody merged(std::size_t body, const Pushed& pushed, double dt, const ExactSums& sums) const;
  void try_motion(std::size_t body, const Pushed& driven, double dt);
  static void for_each_number(auto& state, auto& account, const auto& visit);

  const Physics& physics_;
  const Comm& comm_;
  std::vector<RigidBody> bodies_;  ///< with sampled shapes
  std::vector<RigidStart> starts_;
  std::vector<RigidState> states_;
  RigidCollisions collisions_;
  std::vector<Drive> drives_;
  std::vector<Account> accounts_;
  std::vector<Trial> trials_;
  ExactSums sums_;
  std::vector<Int3> nodes_;
  std::vector<LocalIndex> places_;
  std::vector<NodeConstraint> walls_;  ///< that do not move
  std::vector<std::uint8_t> stuck_;    ///< by place: held by a sticky wall at rest
  std::vector<NodeConstraint> held_, again_;
  bool any_separates_;
  // Of the last `merge`.
  std::vector<Share> shares_;  ///< by place in held_
  ExactSums merged_sums_;      ///< over all ranks
};

}  // namespace bulkley
