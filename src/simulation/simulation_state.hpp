#pragma once
// What a run must remember in addition to its particles, and how it travels through a checkpoint.

#include "simulation/setup.hpp"

#include "balance/tile_load.hpp"
#include "base/named_numbers.hpp"
#include "integrator/energy_budget.hpp"
#include "integrator/integrator.hpp"
#include "kernel/step_bounds.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

/// How the implicit pressure was found in the steps since the last row of history.csv.
struct PressureTotals {
  GlobalIndex n_steps = 0;
  GlobalIndex n_iterations = 0;
  GlobalIndex most_iterations = 0;  ///< of a step
  GlobalIndex n_rounds = 0;

  void add(const PressureReport& report);
};

/// How the viscous motion was found in them, where viscosity is implicit.
struct ViscosityTotals {
  GlobalIndex n_steps = 0;
  GlobalIndex n_iterations = 0;
  GlobalIndex most_iterations = 0;  ///< of a step

  void add(const ViscosityReport& report);
};

struct SimulationState {
  GlobalIndex step = 0;
  double time = 0.0;               ///< s
  GlobalIndex next_frame = 0;      ///< number of the next frame to write
  GlobalIndex frame_tick = 0;      ///< its time in frame intervals; differs from its number once the interval was changed
  GlobalIndex n_removed = 0;       ///< particles that left through outflow faces so far
  GlobalIndex n_repartitions = 0;  ///< changes of the map of tiles to ranks so far
  GlobalIndex n_moved = 0;         ///< particles that those have sent to other ranks so far
  GlobalIndex n_migrated = 0;      ///< particles that have moved to another rank's tile so far
  double dt_last = 0.0;            ///< s, the time step taken last
  CostModel cost;                  ///< of steps, as measured so far; decides how work is shared out, nothing else
  TimeStepState controller;
  StepBounds bounds;
  Reals force_reals;                          ///< of node forces (save_forces); at a checkpoint only
  Integers force_integers;                    ///< likewise
  double history_time = 0.0;                  ///< s, of the last row of history.csv
  std::vector<GlobalIndex> contact_impulses;  ///< ContactImpulses::words since then; at a checkpoint only
  PressureTotals pressure;                    ///< since then
  ViscosityTotals viscosity;                  ///< likewise
  EnergyStart energy_start;                   ///< of the particles when the energy budget began
  std::vector<GlobalIndex> energy_words;      ///< EnergyBudget::words; at a checkpoint only
};

/// Every number of `state` but step and time by name, doubles bit for bit.
void save_state(const SimulationState& state, Reals& reals, Integers& integers);

/// The inverse. Throws RunError naming the first number that is missing.
SimulationState load_state(GlobalIndex step, double time, const Reals& reals, const Integers& integers);

/// When the next frame is due, s: a multiple of the interval, or the end of the run where the two differ by rounding only.
double next_frame_time(const SimulationState& state, double frame_interval, double end_time);

/// After a restart with another frame interval (s): the next frame is due at its next multiple. Otherwise nothing changes.
void fit_frame_tick(SimulationState& state, double frame_interval);

}  // namespace bulkley
