#pragma once
// What every integrator works with: particles and pools, nodal arrays, contact, forces, clocks.

#include <vector>

#include "integrator/energy_budget.hpp"
#include "integrator/feed_particles.hpp"
#include "integrator/node_contact.hpp"
#include "integrator/node_force.hpp"

namespace bulkley {

struct StepParts {
  /// All arguments must outlive this but `node_forces`.
  StepParts(const Physics& all_physics, ParticleGrid& all_particles, NodeForces node_forces, PhaseTimes& phase_times);

  const Physics& physics;
  ParticleGrid& particles;
  NodeContact contact;
  NodeForces forces;
  EnergyBudget budget;
  FeedParticles feeds;
  PhaseTimes& times;
  std::vector<double> material_seconds;  ///< wall time of this rank in the stress updates of each material so far, s
  std::vector<Int3> active_positions;    ///< of Exchange's active nodes; only where there are forces

  /// Makes contact and positions those of the present pools, if they are not yet; true if they were not. Then integrators
  /// fit their arrays. Not collective.
  bool fit();
  /// NodeForce::prepare of all forces. Collective.
  void prepare_forces(double time, double dt);
  /// The force on particles, once it is prepared. Not collective.
  ForceField force_on_particles() const { return forced_by_ ? forces[*forced_by_]->on_particles() : ForceField{}; }
  /// Adds all forces on nodes; none in a step of no duration. Collective.
  void add_forces(const GridUpdate& update, double time, const Node* momenta, Node* impulses, FailureCounts& failures);

  /// Around the motion of a block of particles: what the budget must know of it. Not collective.
  void before_move(ParticleBlock block);
  void after_move(ParticleBlock block);

  /// Impulses that were found after the node update, of all active nodes -> velocities; `change` where given. `impulses` come back
  /// folded. Not collective.
  void add_later_impulses(const GridUpdate& update, Node* impulses, Node* nodes, Node* change);

  /// `bounds` with the waves of forces beside those of the material, and those of what enters. Not collective.
  StepBounds with_waves_of_forces(const StepBounds& bounds, double time) const;

  const Comm& comm() const { return particles.comm(); }
  std::size_t memory() const;

 private:
  GlobalIndex fitted_ = 0;                ///< ParticleGrid::version
  std::optional<std::size_t> forced_by_;  ///< the force that acts on particles
};

}  // namespace bulkley
