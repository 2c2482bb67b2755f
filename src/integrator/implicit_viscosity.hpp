#pragma once
// Implicit viscosity: Newtonian stress of the velocities at the end of a step, one linear system of the nodes a step, solved by
// conjugate gradients whose arithmetic is the same on any number of ranks (docs/theory.md, "Implicit viscosity").

#include "integrator/integrator.hpp"
#include "integrator/pressure_contact.hpp"
#include "kernel/viscous_force.hpp"

namespace bulkley {

class ImplicitViscosity {
 public:
  /// `parts` must outlive this.
  explicit ImplicitViscosity(StepParts& parts);

  /// Makes everything fit the present pools. Not collective.
  void fit();

  /// Finds the velocities that viscosity leaves in a step from `time` and adds its impulses to the owned nodes. `nodes`, `change`:
  /// as ImplicitPressure::apply. `predicted`: further impulses that the step will bring, about, by owned node, images not
  /// folded; empty for none. Where it was not solved, nothing is added; the same on every rank. Collective.
  ViscosityReport apply(double time, const GridUpdate& update, std::span<const Node> predicted, Node* nodes, Node* change);

  /// The particles of `block` know their velocity gradients, field `gradient`, after a step of dt, s. Not collective.
  void record(Field gradient, double dt, ParticleBlock block);

  /// The largest of the materials at rest, m^2/s.
  double kinematic_viscosity() const { return kinematic_viscosity_; }
  std::size_t memory() const;

 private:
  void start(double time, const GridUpdate& update, std::span<const Node> predicted, const Node* nodes);
  bool impulses_of(const NodeVector& velocity, double dt);
  void spread(NodeVector& nodes) const;
  double dot(const NodeVector& a, const NodeVector& b);
  bool solve(double dt, ViscosityReport& report);
  std::span<const LocalIndex> active() const { return parts_.particles.exchange().active_nodes(); }

  StepParts& parts_;
  PressureContact contact_;
  GlobalIndex fitted_ = -1;
  double kinematic_viscosity_ = 0.0;
  std::vector<double> weights_;  // 2 eta J V by particle, J s
  double largest_weight_ = 0.0;  // of all ranks
  // By owned node, in front of walls and behind: {x, y, z, -}.
  std::vector<double> scale_;                 // 1/m, 0 where empty
  std::vector<double> mass_;                  // by active node, 0 where empty
  NodeVector residual_, direction_, spread_;  // m/s; the last: what `spread` makes of impulses_
  NodeVector impulses_;                       // kg m/s, of viscous stress at the velocities asked for
  NodeVector total_;                          // kg m/s, at those found so far
  NodeVector pool_velocity_, pool_force_;
  std::vector<double> addends_;
};

}  // namespace bulkley
