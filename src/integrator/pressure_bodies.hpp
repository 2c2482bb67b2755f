#pragma once
// Free rigid bodies inside the system of the implicit pressure: each moves with the nodes that it holds, as one (docs/theory.md,
// "Implicit pressure").
//
// With bodies that could not move the system is S0. A body adds dt^2 C^T M^-1 C: row k of C is what a pressure in each cell gives to the
// body and its nodes along their k-th freedom, 3 of translation and 3 of rotation, and M their mass matrix. C has entries in cells near
// the body only. Sums over cells are order-free and travel with the scalar products of the solver.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/binned_sum.hpp"
#include "integrator/pressure_contact.hpp"
#include "integrator/rigid_contact.hpp"

namespace bulkley {

class PressureBodies {
 public:
  /// Both must outlive this.
  PressureBodies(const Comm& comm, RigidContact& bodies) : comm_(comm), bodies_(bodies) {}

  /// Of new pools. Not collective.
  void fit(const GridGeometry& grid, const CellGrid& cells);

  /// The constraints of those of `nodes` that bodies hold where they are, with their velocities as they move now. `scale`: 1/m by node,
  /// 0 where it is empty. Valid until the next call. Not collective.
  std::span<const NodeConstraint> find(const CellNodes& nodes, const double* scale);

  /// M, C and the motion without pressure for the walls in force. `velocity`: {v, m} of nodes as walls hold them; `own`: numbers of this
  /// rank's cells. Throws as RigidContact::merge. Collective.
  void merge(double time, const GridUpdate& update, const PressureContact& contact, const Node* velocity,
             const PressureRows& rows, std::span<const LocalIndex> own);

  /// Of the node of a constraint, as part of its body without pressure, m/s. Not collective.
  Vec3 velocity_at(const NodeConstraint& constraint) const { return velocity_at(constraint, velocities_); }
  /// The same with bodies that move so. Not collective.
  Vec3 velocity_at(const NodeConstraint& constraint, std::span<const RigidVelocity> velocities) const {
    return velocities[bodies_.body_of(constraint)].at(constraint.arm);
  }

  bool any_separates() const { return bodies_.any_separates(); }

  /// C p of each body, kg m/s^2 (lengths in the body's unit).
  using Coupling = std::vector<Vec6>;
  /// Of `p`, by number of the cell. Collective.
  Coupling couple(std::span<const double> p) const;
  /// How bodies move with a pressure of this coupling through a step of dt, s. Not collective.
  std::vector<RigidVelocity> velocities_under(const Coupling& coupling, double dt) const;
  /// The product of a and p, and C p; one reduction. Collective.
  double dot(std::span<const double> a, std::span<const double> p, Coupling& coupling) const;
  /// rates += C^T M^-1 (C p) of this rank's cells. Not collective.
  void add_rates(const Coupling& coupling, double* rates) const;
  /// diagonal += that of C^T M^-1 C. Not collective.
  void add_diagonal(double* diagonal) const;

  std::size_t memory() const;

 private:
  /// C of one body.
  struct Modes {
    std::vector<LocalIndex> cells;
    std::array<std::vector<double>, 6> row;  ///< by place in `cells`
  };
  /// A node that moves with a body, or the image of one.
  struct MovedNode {
    std::size_t body;
    std::array<Vec3, 6> velocity;  ///< along each freedom
  };
  void find_modes(const PressureContact& contact, const PressureRows& rows, std::span<const LocalIndex> own);
  void find_moved(const PressureContact& contact);
  void add_sums(std::span<const double> p, std::vector<BinnedSum>& sums) const;
  Coupling merged(std::vector<BinnedSum>& sums, std::size_t first) const;

  const Comm& comm_;
  RigidContact& bodies_;
  std::vector<LocalIndex> nodes_;
  std::vector<Vec3> positions_;
  std::vector<NodeConstraint> held_;
  std::vector<MergedBody> systems_;
  std::vector<RigidVelocity> velocities_;
  std::vector<LocalIndex> moved_of_node_;  // in moved_; -1: none
  std::vector<MovedNode> moved_;
  std::vector<Modes> modes_;
};

}  // namespace bulkley
