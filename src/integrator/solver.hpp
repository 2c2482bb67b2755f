#pragma once
// The distributed step: particles, grid and pools of one run, and one time step on them.

#include <memory>
#include <optional>
#include <vector>

#include "balance/partition.hpp"
#include "config/formula.hpp"
#include "distribution/exchange.hpp"
#include "distribution/migrate.hpp"
#include "integrator/reduce_bounds.hpp"
#include "kernel/cells.hpp"
#include "kernel/grid_update.hpp"
#include "material/material.hpp"
#include "parallel/log.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

/// What the step needs to know of a scene.
struct Physics {
  GridGeometry grid;
  TransferSettings transfer;
  TimeStepSettings time_stepping;
  Vec3 gravity = Vec3::Zero();  ///< m/s^2
  std::vector<NamedMaterial> materials;
  Faces faces;
  std::vector<Collider> colliders;
  VectorFormula acceleration_field;  ///< m/s^2, of x, y, z, t
};

/// No sums yet, in the units of these physics.
ContactImpulses no_contact_impulses(const Physics& physics);

/// How a step went.
struct StepReport {
  TimeStepPlan plan;   ///< the plan that was carried out
  int n_rejected = 0;  ///< plans judged bad before it
  StepBounds bounds;   ///< merged over ranks, after the step
};

/// Owns the particles of this rank and everything that turns them into those of the next time.
class Solver {
 public:
  /// `particles`: any distribution over ranks; they are sent to the workers of their tiles. `bounds`: those a checkpoint
  /// holds, or none at the start of a run, when they are measured. `comm` must outlive the solver. Collective.
  Solver(const Comm& comm, Physics physics, Partition partition, ParticleSet particles, std::optional<StepBounds> bounds);
  ~Solver();

  const Physics& physics() const { return physics_; }
  const ParticleSet& particles() const { return particles_; }
  const StepBounds& bounds() const { return bounds_; }
  const Partition& partition() const { return partition_; }
  /// The nodes as node_values has given them. Precondition: it has been called since the start or the last change of maps.
  const Grid& grid() const { return *grid_; }
  PhaseTimes& times() { return times_; }
  const PhaseTimes& times() const { return times_; }
  const Exchange& exchange() const { return *exchange_; }
  /// What this rank sends to others in one step to add up nodes and to bring velocities back. Not collective.
  GlobalIndex halo_bytes() const;
  GlobalIndex n_rebuilds() const { return n_rebuilds_; }
  /// {v, m} of the DMDA's nodes that the particles as they are give, boundaries applied; zero where no particle reaches.
  /// `time`: where moving colliders stand, s. Changes no particle. Precondition: the partition has boxes. Throws UsageError where
  /// PETSc cannot number the nodes. Collective.
  VecHandle node_values(double time);

  /// Advances by one time step of at most `remaining` seconds. `stop_request` rides on the all-reduce and comes back merged
  /// in bounds.stop_request. `time`: at the start of the step, s, for the acceleration field and moving colliders. Throws
  /// StepFailure, alike on every rank, when particles fail or no step can be taken. Collective.
  StepReport step(double remaining, int stop_request, TimeStepState& state, double time = 0.0);

  /// What the material has given to the colliders since the start or the last set_contact_impulses, over all ranks; the same
  /// bits on any number of ranks. Collective.
  ContactImpulses contact_impulses() const;
  /// Goes on from such sums: those of a checkpoint, or none. Not collective (alike on every rank).
  void set_contact_impulses(const ContactImpulses& sums);

  /// What each tile holds of this rank's particles. Not collective.
  TileCensus census() const { return take_census(physics_.grid, particles_, static_cast<int>(physics_.materials.size())); }

  /// Goes on under another partition: sends the particles to its workers.
  /// Returns the number of particles that have changed ranks. No particle changes otherwise. Collective.
  GlobalIndex adopt(Partition partition);

  /// Wall time of this rank in the stress updates of each material so far, s.
  const std::vector<double>& material_seconds() const { return material_seconds_; }
  /// Of the wall time in phase "exchange", what went into waiting for other ranks so far, s.
  double exchange_wait() const { return exchange_wait_ + exchange_->seconds_waiting(); }

  /// Bytes of particles, pools, grid and work arrays on this rank. Not collective.
  std::size_t memory() const;

 private:
  void transfer_to_grid(double dt, double time, StepBounds& faults);
  void accelerate(const GridUpdate& update, double time, Node* nodes, Node* impulse, StepBounds& faults);
  StepReport take_step(double remaining, int stop_request, TimeStepState& state, double time);
  StepBounds motion_of_trial(const StepBounds& faults);
  void transfer_to_particles(double dt, StepBounds& local);
  void settle(StepBounds& local);
  void start_placing();
  void place(ParticleBlock block, StepBounds& outside);
  void send_strays(StepBounds& local);
  void rebuild();
  void measure_start();
  [[noreturn]] void report_failure() const;

  const Comm& comm_;
  Physics physics_;
  Partition partition_;
  ParticleSet particles_;
  StepBounds bounds_;
  BoundsReduction reduce_;
  std::optional<Grid> grid_;          ///< of the present boxes, once nodes have been asked for: a step needs none
  NodeVector owned_, owned_impulse_;  ///< by Exchange; the second only where the transfer needs the velocity change
  PoolLayout layout_;
  std::unique_ptr<Exchange> exchange_;
  NodeVector pool_, impulse_;
  std::vector<NodeConstraint> constraints_;
  std::optional<MovingConstraints> moving_constraints_;  ///< only where a collider moves
  ContactImpulses trial_impulses_;                       ///< of the step being tried
  ContactImpulses contact_impulses_;                     ///< of the steps taken
  std::vector<NodeImage> images_;
  std::vector<Int3> active_positions_;  ///< of Exchange's active nodes; only where there is an acceleration field
  std::optional<VectorField> acceleration_;
  CellMap map_;
  std::vector<Stray> strays_;
  std::vector<LocalIndex> removed_, departed_;
  std::vector<Departure> departures_;
  PhaseTimes times_;
  std::vector<double> material_seconds_;
  double exchange_wait_ = 0.0;  ///< of exchanges that are gone
  GlobalIndex n_jumps_ = 0;     ///< since the last sort
  GlobalIndex n_rebuilds_ = 0;
};

}  // namespace bulkley
