#pragma once
// The adaptive time step (docs/theory.md, "Time step"): bounds -> dt and which bound limited it; grow, accept, reject.

#include <string>

#include "kernel/step_bounds.hpp"
#include "kernel/transfer.hpp"
#include "stepping/failure.hpp"

namespace bulkley {

/// How nodes get their velocities: all forces at the start of the step, or the pressure at its end.
enum class IntegratorKind { explicit_step, imex };

/// Who solves for the implicit pressure: our conjugate gradients, the same bits on any number of ranks, or PETSc.
enum class PressureSolver { cg, petsc };

/// What the names of PETSc's options for that solver begin with.
inline constexpr const char* petsc_pressure_prefix = "-bulkley_pressure_";

/// The implicit pressure of integrator imex, table [time.pressure] of a scene (docs/theory.md, "Implicit pressure").
struct PressureSettings {
  double tolerance = 1e-3;      ///< of the residual, in the energy norm of the diagonal
  int max_iterations = 300;     ///< beyond, the step is rejected
  double stabilisation = 0.05;  ///< zeta of (I7)
  double relaxation = 0.1;      ///< beta of (I9)
  int contact_rounds = 5;       ///< solutions a step, at most, to find which walls hold
  PressureSolver solver = PressureSolver::cg;
  std::string petsc_options;  ///< for PETSc's solver, each beginning with petsc_pressure_prefix
};

/// Whether a Newtonian stress is that of the velocities at the start of a step or at its end.
enum class ViscosityKind { explicit_stress, implicit_stress };

/// Implicit viscosity, table [time.viscous] of a scene (docs/theory.md, "Implicit viscosity").
struct ViscousSettings {
  double tolerance = 1e-3;   ///< of the change of velocity, in the energy norm of the system
  int max_iterations = 300;  ///< beyond, the step is rejected
};

enum class TimeStepMode { adaptive, fixed };
enum class DeformationCheck { risky, always };

/// The user's choices, table [time] of a scene.
struct TimeStepSettings {
  double end_time = 0.0;  ///< s
  IntegratorKind integrator = IntegratorKind::explicit_step;
  PressureSettings pressure;
  ViscosityKind viscosity = ViscosityKind::explicit_stress;
  ViscousSettings viscous;
  TimeStepMode mode = TimeStepMode::adaptive;
  double dt_fixed = 0.0;                ///< s, mode fixed
  bool allow_unstable = false;          ///< fixed step above the limits: warn instead of refusing
  double dt_initial = 0.0;              ///< s; 0: a tenth of the limit at the start
  double dt_max = 0.0;                  ///< s; 0: no bound of the user's
  double dt_min = 0.0;                  ///< s; below it the run fails. 0: 1e-6 of the first limit
  double cfl = 0.5;                     ///< beta of report eq. (2): dt <= beta dx / v_max
  double elastic_cfl = 0.4;             ///< alpha of report eq. (2): dt <= alpha dx / c_max
  double viscous_cfl = 0.5;             ///< dt <= viscous_cfl dx^2 / (6 nu_max)
  double deformation_limit = 0.1;       ///< theta: largest ||dt L_p||_F of a step
  double growth = 1.5;                  ///< factor of a trial
  int trial_interval = 10;              ///< steps between trials
  double smallest_volume_ratio = 1e-4;  ///< J below which the run fails
  double largest_volume_ratio = 1e6;    ///< J above which the run fails
  DeformationCheck deformation_check = DeformationCheck::risky;
  double step_timeout =
      600.0;  ///< s of wall time; a step that takes longer, and 20 times the slowest, ends the run; 0: never
};

/// What set the time step.
enum class Limiter : int { speed, collider, elastic, viscous, deformation, previous, largest, fixed, output };
const char* name(Limiter limiter);

/// The controller's memory; part of every checkpoint.
struct TimeStepState {
  double dt_stable = 0.0;       ///< dt_s: the last step that was accepted in full, s; 0 before the first
  double dt_first_limit = 0.0;  ///< the limit at the first step, s; scales the smallest step
  GlobalIndex wait = 0;         ///< steps to wait before the next trial (doubled by each rejected one)
  GlobalIndex since_trial = 0;  ///< steps since the last trial
  GlobalIndex n_steps = 0;
  GlobalIndex n_trials = 0;
  GlobalIndex n_accepted = 0;         ///< trials accepted
  GlobalIndex n_rejected = 0;         ///< steps rejected before they were taken, trials or not
  GlobalIndex n_unchecked_large = 0;  ///< steps taken without a check that turned out to deform more than the limit
};

/// The limits of one step (report eq. 2 as corrected in docs/theory.md), each with the particle that sets it.
struct TimeStepLimit {
  double dt;
  Limiter limiter;
  GlobalIndex id;  ///< particle, or -1
};

/// What the controller proposes.
struct TimeStepPlan {
  double dt;  ///< s, clipped to the next output
  Limiter limiter;
  GlobalIndex id;    ///< of the particle that limits, or -1
  bool trial;        ///< larger than the last stable step
  bool checked;      ///< must be checked before particles change
  bool lands;        ///< ends exactly at the next output time
  bool full;         ///< not clipped
  double unclipped;  ///< s: dt as no output would have it; what an implicit pressure is stabilised by
};

/// With an implicit pressure `settings` of which no step is longer than a fall from rest through cfl dx: an inviscid fluid at
/// rest has no other limit. Otherwise `settings`. `gravity`: m/s^2, >= 0. Not collective.
TimeStepSettings limited_by_fall(const TimeStepSettings& settings, double cell_size, double gravity);

/// (T26): min(beta dx / v_max, the same of `collider_speed`, m/s, alpha dx / c_max, viscous_cfl dx^2 / (6 nu_max), 0.8 theta
/// / ||L||_max of the last step, dt_max). Not collective.
TimeStepLimit time_step_limit(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds,
                              double collider_speed);

/// What is wrong with a fixed step above the stability limits (speed, elastic, viscous, largest), as a sentence; empty when
/// it is below them or the mode is adaptive. Not collective.
std::string fixed_step_fault(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds);

/// The step to try next, with `remaining` seconds to the next output time. Starts `state` at the first call. Throws NoStep
/// when a fixed step is above the limits and that is not allowed, when the limit is below the smallest step, and when there
/// is none. Not collective (the same on every rank).
TimeStepPlan plan_step(const TimeStepSettings& settings, double cell_size, const StepBounds& bounds, double collider_speed,
                       double remaining, TimeStepState& state);

/// Whether a tentative step with the particle motion `motion` (measure_motion, merged over ranks) may be taken:
/// dt ||L||_max <= theta, no particle crosses a cell, all finite. Not collective.
bool is_acceptable(const TimeStepSettings& settings, double cell_size, const TimeStepPlan& plan, const StepBounds& motion);

/// Limits of a particle's motion within which is_acceptable cannot fail, less what mass that is rounded away can add. Not
/// collective.
MotionLimits ample_limits(const TimeStepSettings& settings, double cell_size, const TimeStepPlan& plan);

/// After a bad step: a trial falls back to the last stable step and doubles the wait; any other halves the stable step.
/// `motion`: the motion that the plan was checked with. Throws NoStep below the smallest step. Not collective.
void reject_step(const TimeStepSettings& settings, const TimeStepPlan& plan, const StepBounds& motion, TimeStepState& state);

/// The implicit parts of a step.
enum class ImplicitPart { pressure, viscosity };

/// After a step of which `part` was not solved: as reject_step. `fault`: how the solver ended, to follow "the pressure is not
/// found"; empty: by its iterations. Throws NoStep below the smallest step, and where the step is fixed. Not collective.
void reject_unsolved(const TimeStepSettings& settings, const TimeStepPlan& plan, ImplicitPart part, const std::string& fault,
                     TimeStepState& state);

/// After a step was taken; `bounds` are those it ended with. Not collective.
void accept_step(const TimeStepSettings& settings, const TimeStepPlan& plan, const StepBounds& bounds, TimeStepState& state);

}  // namespace bulkley
