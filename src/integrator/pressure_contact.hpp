#pragma once
// Walls, colliders and the feeds of inflows inside the linear systems of an implicit step, as projections (docs/theory.md, "Implicit pressure").
//
// Each rank finds the constraints of the nodes that it needs by itself: they follow from geometry, and from velocities and masses
// of those nodes.

#include <optional>
#include <span>
#include <vector>

#include "distribution/cell_nodes.hpp"
#include "distribution/cell_waves.hpp"
#include "integrator/feed_nodes.hpp"
#include "integrator/physics.hpp"
#include "kernel/grid_update.hpp"

namespace bulkley {

class PressureContact {
 public:
  /// `physics` must outlive this.
  explicit PressureContact(const Physics& physics) : physics_(physics), feeds_(physics) {}

  /// Finds what touches the complete nodes of `cells`. Not collective.
  void fit(const CellGrid& cells);
  /// The waves of products with the nodes of `cells`, images completed together. Not collective.
  const CellWaves& waves() const { return waves_; }
  /// From here on those nodes of `cells` exist for which `takes_part`, by number there, is not 0, and those which they need, which
  /// it marks: their images. Nodes of all that follows go by their numbers in `nodes()`. Not collective.
  void select(const CellGrid& cells, std::span<char> takes_part);
  const CellNodes& nodes() const { return numbers_; }
  /// No other rank owns the node. Not collective.
  bool owns(LocalIndex node) const { return is_owned_[static_cast<std::size_t>(node)] != 0; }
  /// The nodes from here on have no part in this wave or those before it. Not collective.
  LocalIndex end_of_nodes(LocalIndex wave) const { return end_of_wave_[static_cast<std::size_t>(wave)]; }

  /// Finds what touches nodes at these `positions` in the grid, which are `nodes` of arrays of `n_nodes`; one wave has them all.
  /// In place of `fit` and `select`. Not collective.
  void fit(const std::vector<Int3>& positions, std::span<const LocalIndex> nodes, LocalIndex n_nodes);

  /// The constraints of a step from `time`, each separating one in force where the material comes towards it. `stretches`: of the
  /// feeds, as FeedNodes::at; `velocity`: {v, -} of the nodes before contact. `bodies`: of nodes that rigid bodies hold, each once, with
  /// the velocity of the body;
  /// what a sticky wall holds is the wall's. Not collective.
  void begin(double time, double dt, std::span<const double> stretches, const Node* velocity,
             std::span<const NodeConstraint> bodies = {});

  /// Velocities before contact -> as the walls in force hold them. Not collective.
  void hold_by_walls(Node* velocity) const;
  /// Velocities before contact -> as walls and bodies hold them, and behind walls as their images. `velocity_of`: of a body that holds a
  /// node, m/s, from its constraint. Not collective.
  template <class F>
  void hold(Node* velocity, F velocity_of) const {
    hold_by_walls(velocity);
    for (const BodyNode& body : body_nodes_)
      if (body.in_force) hold_by_body(body, velocity_of(body.constraint), velocity);
    complete(velocity);
  }
  void hold(Node* velocity) const {
    hold_by_walls(velocity);
    complete(velocity);
  }
  /// The nodes of bodies that move with them, as f(constraint, P of the walls there). Not collective.
  template <class F>
  void for_each_body_node(F f) const {
    for (const BodyNode& body : body_nodes_)
      if (body.in_force) f(body.constraint, body.walls);
  }
  std::span<const NodeImage> images() const { return images_.things; }
  std::span<const CellGrid::Copy> repeated() const { return repeated_.things; }
  /// Impulses on the nodes of a wave -> changes of velocity that keep to the constraints: T M^-1 P T^T, T being the mirror
  /// images; of bodies, as if they could not move. `scale`: 1/m of a node, 0 where it is empty. Changes outside of constraints are those
  /// of free nodes. Not collective.
  void spread(const double* scale, LocalIndex wave, Node* impulses) const;
  /// T and P of `spread` one by one, for who assembles it: the node that each of `n_nodes` is the image of, or has its first number
  /// from, and the sign of each component; most are their own. And P of the nodes that constraints hold, as f(node, P). Not
  /// collective.
  struct Source {
    LocalIndex node;
    Vec3 sign;
  };
  std::vector<Source> sources(std::size_t n_nodes) const;
  template <class F>
  void for_each_projection(F f) const {
    for (const HeldNode& held : held_.things) f(held.node, held.projection);
  }
  /// Of a node's change along each axis, the part that its constraints leave; 0 behind walls. For preconditioners.
  void weaken(Node* scales) const;

  /// Impulses of nodes behind walls -> their images. Not collective.
  void fold(Node* impulses) const { fold_impulses(images(), impulses); }
  /// Lifts separating constraints that would pull, and puts in force those that `free` velocities, in which no constraint has its
  /// effect, would penetrate. `tolerance`: of speed, m/s; `bodies`: how they move with this pressure. Returns how many changed at
  /// nodes of this rank, so that sums over ranks count each once. Not collective.
  GlobalIndex revise(const double* scale, const Node* free, double tolerance, std::span<const RigidVelocity> bodies = {});

  std::size_t memory() const;

 private:
  struct Constraint {
    Contact contact;
    bool in_force;
    Vec3 normal, velocity;
  };
  struct HeldNode {
    LocalIndex node;
    std::size_t first, end;  // of its constraints
    Mat3 projection;         // P of a velocity, P u + offset
    Vec3 offset;
    std::ptrdiff_t body = -1;  // in body_nodes_
  };
  // The walls of it take P before the body and after it: projection is P (1 - N) P, and `walls` P.
  struct BodyNode {
    NodeConstraint constraint;
    std::size_t held;
    Mat3 walls;
    bool in_force;
  };
  const Mat3& walls_of(const HeldNode& held) const {
    return held.body < 0 ? held.projection : body_nodes_[static_cast<std::size_t>(held.body)].walls;
  }
  void project(HeldNode& held);
  void project_walls(HeldNode& held) const;
  void join(std::span<const NodeConstraint> bodies, const Node* velocity);
  bool revise_body(BodyNode& body, const Vec3& velocity, double tolerance, std::span<const RigidVelocity> bodies) const;
  void hold_by_body(const BodyNode& body, const Vec3& velocity, Node* nodes) const;
  void complete(Node* velocity) const;
  void find(const std::vector<Int3>& positions, std::span<const LocalIndex> nodes);
  void sort_by_wave();
  void select();
  LocalIndex wave_of(LocalIndex node) const { return wave_of_[static_cast<std::size_t>(node)]; }

  // Things of nodes, sorted by the wave of the node.
  template <class Thing>
  struct ByWave {
    std::vector<Thing> things;
    WaveRanges ranges;
    std::span<const Thing> of(LocalIndex wave) const { return ranges.of(things, wave); }
  };

  const Physics& physics_;
  // Of the pools, by the numbers of the CellGrid.
  CellWaves waves_;
  std::vector<LocalIndex> all_nodes_;
  std::vector<CellGrid::Copy> all_repeated_;
  std::vector<NodeImage> all_images_;
  std::vector<NodeConstraint> fixed_;
  std::optional<MovingConstraints> moving_;
  FeedNodes feeds_;
  // Of the step, by the numbers of those that take part.
  CellNodes numbers_;
  std::vector<std::uint8_t> is_owned_;             // by node
  std::vector<LocalIndex> wave_of_, end_of_wave_;  // by node; by wave
  ByWave<LocalIndex> nodes_;
  ByWave<CellGrid::Copy> repeated_;
  ByWave<NodeImage> images_;
  ByWave<HeldNode> held_;
  std::vector<Constraint> constraints_;
  std::vector<BodyNode> body_nodes_;
};

/// N of a body's constraint: 1 where it sticks, n n^T where it slips or separates. Not collective.
Mat3 held_part(const NodeConstraint& body);

}  // namespace bulkley
