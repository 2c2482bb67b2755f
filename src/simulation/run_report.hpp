#pragma once
// What a run reports: rows of history.csv, progress lines, the summary at the end.

#include <string>
#include <vector>

#include "integrator/diagnostics.hpp"
#include "integrator/solver.hpp"
#include "io/status/history.hpp"
#include "io/status/status.hpp"
#include "rebalance/balancer.hpp"
#include "simulation/simulation.hpp"
#include "simulation/simulation_state.hpp"

namespace bulkley {

/// Column names of history.csv, with units.
std::vector<std::string> history_columns(const Scene& scene);

/// What the material does to colliders and gauges, on average since the row before.
struct ContactForces {
  ContactImpulses impulses;  ///< entries as no_contact_impulses has them
  double duration = 0.0;     ///< s, since the row before
};

/// What ranks send to each other in one step, bytes.
struct HaloTraffic {
  GlobalIndex largest = 0;  ///< of one rank
  GlobalIndex total = 0;
};

/// What an inflow has brought in.
struct FedFigures {
  double mass;                       ///< kg, density times the volume that has entered
  double particle_mass;              ///< kg, of the particles that have passed the exit: the same within half a layer
  GlobalIndex n_entered, n_in_feed;  ///< particles past the exit, and still behind it
  GlobalIndex n_pushed_back;         ///< how often one that came back into the feed was put back to the exit
  double pressure;                   ///< Pa, at which material enters
};

/// In addition to Diagnostics.
struct Measurements {
  double thickness_decile;                  ///< cells; see the function of that name; on the root alone
  std::vector<double> reaches;              ///< m, of each front
  std::vector<double> gauge_areas;          ///< m^2, of each gauge
  std::vector<double> forces;               ///< Solver::force_history
  std::vector<std::vector<double>> bodies;  ///< RigidContact::history
  std::vector<FedFigures> fed;              ///< by each inflow
};

/// Of each feed of the solver at a time, s. Collective.
std::vector<FedFigures> fed_figures(const Scene& scene, const Solver& solver, double time);

/// Means over the steps that `totals` counts. Not collective.
PressureFigures pressure_figures(const PressureTotals& totals);
ViscosityFigures viscosity_figures(const ViscosityTotals& totals);

/// One row; `seconds_per_step`: wall time per step since the row before.
std::vector<HistoryValue> history_row(const Scene& scene, const SimulationState& state, const StepReport* report,
                                      const Diagnostics& diagnostics, const EnergyAccount& energies,
                                      const ContactForces& contact, const Measurements& measured, const HaloTraffic& halo,
                                      int n_ranks, double seconds_per_step);

/// Largest over mean number of particles per rank.
double particle_imbalance(const StepBounds& bounds, int n_ranks);

/// What the run has cost so far, on this rank's clock.
struct RunClock {
  double start = 0.0;                ///< MPI_Wtime at the start
  double stepping = 0.0;             ///< s in steps
  double output = 0.0;               ///< s in frames, history and checkpoints
  double particle_steps = 0.0;       ///< sum over steps of the global number of particles
  double largest_share_steps = 0.0;  ///< sum over steps of the particles of the most loaded rank
  double slowest_step = 0.0;         ///< s, a step with its output, but for checkpoints
  GlobalIndex first_step = 0;        ///< step number the process started from
  double first_time = 0.0;           ///< s, the time it started from
};

inline constexpr std::size_t most_warnings_kept = 20;  ///< in status.json

/// What is known of a run before its first step, with the warnings about its scene. Not collective.
RunProgress progress_at_start(const Comm& comm, const Scene& scene, const RunOptions& options);

/// Brings up to date what this rank knows by itself: particles and wall times. Not collective.
void update_clock(const SimulationState& state, const RunClock& clock, RunProgress& progress);

/// Brings `progress` up to date, but for its warnings and its checkpoint. Collective.
void update_progress(const Comm& comm, const SimulationState& state, const RunClock& clock, const PhaseTimes& times,
                     RunProgress& progress);

/// step, time, time step and its limiter, particles, largest speed, imbalance, rate, elapsed and remaining time.
std::string progress_line(const SimulationState& state, const TimeStepPlan& plan, double end_time, const RunClock& clock,
                          int n_ranks);

/// Lines at the end of a run: steps, rejected trials, ns per particle per step overall and per phase, imbalance, output
/// time, peak memory per rank. Collective.
std::string run_summary(const Comm& comm, const SimulationState& state, const RunClock& clock, const PhaseTimes& times,
                        const BalanceTotals& balance, const HaloTraffic& halo);

}  // namespace bulkley
