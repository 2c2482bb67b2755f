#pragma once
// Particles and all that advances them: transport, integrator, forces and contact of one run.

#include <optional>

#include "field/tile_scatter.hpp"
#include "integrator/integrator.hpp"

namespace bulkley {

/// The integrator that a scene asks for. Not collective.
std::unique_ptr<Integrator> integrator_of(StepParts& parts);

class Solver {
 public:
  /// `particles`: any distribution over ranks; they are sent to the owners of their tiles. `bounds`: those of a checkpoint,
  /// or none at the start of a run, when they are measured. `forces`, `make_integrator`: by default what `physics` asks for.
  /// `comm` must outlive the solver. Throws StepFailure, the same on every rank, when a particle is outside the domain.
  /// Collective.
  Solver(const Comm& comm, Physics physics, Partition partition, ParticleSet particles, std::optional<StepBounds> bounds);
  Solver(const Comm& comm, Physics physics, Partition partition, ParticleSet particles, std::optional<StepBounds> bounds,
         NodeForces forces, const MakeIntegrator& make_integrator);
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  const Physics& physics() const { return physics_; }
  const ParticleSet& particles() const { return grid_.particles(); }
  const StepBounds& bounds() const { return grid_.bounds(); }
  const Partition& partition() const { return grid_.partition(); }
  const Exchange& exchange() const { return grid_.exchange(); }
  const Integrator& integrator() const { return *integrator_; }
  PhaseTimes& times() { return times_; }
  const PhaseTimes& times() const { return times_; }

  /// Takes one step. Throws StepFailure, the same on every rank, when particles fail or no step can be taken. Collective.
  StepReport step(const StepRequest& request, TimeStepState& state);

  /// What limits dt in a step from `time`, s, of at most `remaining`, s. Not collective (the same on every rank).
  TimeStepLimit dt_limit(double time, double remaining) const { return integrator_->dt_limit(bounds(), time, remaining); }

  /// What this rank sends to others in one step to add up nodes and to bring velocities back. Not collective.
  GlobalIndex halo_bytes() const;
  /// The grid that node_values fills. Precondition: it has been called.
  const FieldGrid& grid() const { return *node_grid_; }
  /// {v, m} that the particles as they are give to this rank's nodes of grid(), boundaries applied; zero where no particle
  /// reaches. `time`: for the positions of moving colliders, s. Changes no particle. Throws UsageError where PETSc cannot
  /// number the nodes. Collective.
  std::vector<Node> node_values(double time);

  /// What the material has given to the colliders since the start or the last set_contact_impulses, over all ranks; the same
  /// bits on any number of ranks. Collective.
  ContactImpulses contact_impulses() const { return parts_.contact.impulses(grid_.comm()); }
  /// Continues from such sums: those of a checkpoint, or none. Not collective (the same on every rank).
  void set_contact_impulses(const ContactImpulses& sums) { parts_.contact.set_impulses(grid_.comm(), sums); }

  /// The energy budget since its beginning, merged over ranks. Collective.
  EnergyTotals energy_totals() const { return parts_.budget.totals(grid_.comm()); }
  /// EnergyBudget::words, set_words.
  std::vector<std::int64_t> energy_words() const { return parts_.budget.words(grid_.comm()); }
  bool set_energy_words(std::span<const std::int64_t> words) { return parts_.budget.set_words(grid_.comm(), words); }
  /// NodeForce::fields of the first force that has any. Collective.
  std::optional<BoxFields> force_fields(double time);
  /// NodeForce::history of all forces, one after the other. Not collective.
  std::vector<double> force_history() const;
  std::size_t n_forces() const { return parts_.forces.size(); }

  /// The rigid bodies of the run, if there are any; nullptr else. Not collective.
  RigidContact* rigid_bodies() { return parts_.contact.rigid_bodies(); }

  /// By inflow: NozzleState::stretch, and how often particles were pushed back to its exit so far, over all ranks. Collective.
  std::span<const double> feed_stretches() const { return parts_.feeds.stretches(); }
  std::vector<GlobalIndex> pushed_back() const { return parts_.feeds.pushed_back(grid_.comm()); }

  /// What forces, rigid bodies and inflows must find again after a restart; see NodeForce::save. Collective.
  void save_forces(Reals& reals, Integers& integers) const;
  void load_forces(const Reals& reals, const Integers& integers);
  /// NodeForce::save_fields, load_fields of all forces. Collective.
  std::vector<BoxFields> save_force_fields() const;
  void load_force_fields(const BoxSource& source);

  /// What each tile holds of this rank's particles. Not collective.
  TileCensus census() const { return grid_.census(); }
  /// ParticleGrid::adopt. Collective.
  GlobalIndex adopt(Partition partition);

  /// Wall time of this rank in the stress updates of each material so far, s.
  const std::vector<double>& material_seconds() const { return parts_.material_seconds; }
  double exchange_wait() const { return grid_.exchange_wait(); }

  /// Bytes of particles, pools, grid and work arrays on this rank. Not collective.
  std::size_t memory() const { return grid_.memory() + parts_.memory() + integrator_->memory(); }

 private:
  [[noreturn]] void report_failure(const StepBounds& bounds) const;

  Physics physics_;
  PhaseTimes times_;
  ParticleGrid grid_;
  StepParts parts_;
  std::unique_ptr<Integrator> integrator_;
  std::optional<FieldGrid> node_grid_;       ///< once nodes have been asked for: a step needs none
  std::optional<TileScatter> to_node_grid_;  ///< likewise, for the pools of this version
  GlobalIndex scatter_version_ = -1;
};

}  // namespace bulkley
