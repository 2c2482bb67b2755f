#pragma once
// The explicit step: symplectic Euler on the nodes, dt bounded by the elastic wave, viscosity, speed and deformation
// (docs/theory.md). With an implicit pressure (integrator imex) the same, but that the pressure of laws with a volumetric part
// is that of the end of the step, and their waves of pressure bound nothing; likewise with implicit viscosity.

#include <memory>

#include "integrator/cell_dilation.hpp"
#include "integrator/crowding.hpp"
#include "integrator/floor_pressure.hpp"
#include "integrator/implicit_pressure.hpp"
#include "integrator/implicit_viscosity.hpp"
#include "integrator/integrator.hpp"
#include "integrator/shear_layers.hpp"
#include "kernel/p2g.hpp"

namespace bulkley {

class ExplicitStep : public Integrator {
 public:
  explicit ExplicitStep(StepParts& parts);

  StepReport step(const StepRequest& request, TimeStepState& state) override;
  void fit() override;
  TimeStepLimit dt_limit(const StepBounds& bounds, double time, double remaining) const override;
  bool is_exact() const override {
    const Physics& physics = parts_.physics;
    return physics.time_stepping.pressure.solver == PressureSolver::cg &&
           !(physics.magnets && physics.magnets->settings.solver == FieldSolver::petsc);
  }
  std::span<const Node> node_velocities(double time) override;
  int n_exchanges() const override { return parts_.physics.transfer.n_exchanges(); }
  std::size_t bytes_per_iteration() const override { return pressure_ ? pressure_->bytes_per_iteration() : 0; }
  std::size_t memory() const override;

 private:
  double collider_speed(const StepBounds& bounds, double time, double remaining) const;
  double kept_share(double dt) const;
  void particles_to_nodes(double time, double dt, const SumBounds& sums, const ForceField& force);
  void update_nodes(double time, const GridUpdate& update, StepReport& report, StepBounds& local);
  void solve_implicit_parts(double time, const GridUpdate& update, StepReport& report);
  void push_nodes(double time, const GridUpdate& update, StepBounds& local);
  void nodes_to_pools();
  void compute_nodes(double time, double dt, StepReport& report, StepBounds& local);
  StepBounds trial_motion(const TimeStepPlan& plan, const StepBounds& local);
  void nodes_to_particles(double dt, StepBounds& local);

  Node* change() { return impulses_ == Impulses::joined ? nullptr : change_.data(); }

  StepParts& parts_;
  StressOfState stress_;
  double shear_wave_speed_ = 0.0;  ///< m/s, the largest of the materials at rest
  bool splits_;           ///< particles get the change of velocity, too, for the transfer keeps a residual
  Impulses impulses_;     ///< apart where splits_; both where only the energy budget asks for them
  NodeVector pool_;       ///< {m v + dt f, m}, then {v, m}; unless splits_
  NodePairVector pairs_;  ///< of the pool, unless impulses_ are joined
  NodeVector velocity_;   ///< {m v, m}, then {v, m} of the owned nodes
  NodeVector change_;     ///< {dt f, -}, then the change of velocity in the step; unless impulses_ are joined
  FloorPressure floor_pressure_;
  Crowding crowding_;
  ShearLayers layers_;
  std::unique_ptr<CellDilation> dilation_;      ///< none where every particle keeps its own volume
  std::unique_ptr<ImplicitPressure> pressure_;  ///< none where all forces are explicit
  std::unique_ptr<ImplicitViscosity> viscosity_;
  ContactImpulses received_;  ///< by the colliders from this rank's nodes in the step being tried
};

}  // namespace bulkley
