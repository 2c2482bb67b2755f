#pragma once
// One run between its start and its end: what the run loop, its outputs and its stop criteria share.

#include <memory>
#include <string>
#include <vector>

#include "integrator/solver.hpp"
#include "io/status/status.hpp"
#include "parallel/watchdog.hpp"
#include "rebalance/balancer.hpp"
#include "simulation/run_report.hpp"
#include "simulation/simulation.hpp"
#include "simulation/simulation_state.hpp"

namespace bulkley {

class Output;
class StopCriterion;

/// The newest checkpoint on disk.
struct LastCheckpoint {
  std::string file;        ///< empty: none yet
  GlobalIndex step = -1;   ///< -1: none yet
  double wall_time = 0.0;  ///< MPI_Wtime when it was written, or the start; the root's clock decides
  double seconds = 0.0;    ///< that it took; 0: none was written in this part of the run
};

struct Run {
  /// Seeds the scene or reads a checkpoint, as `options` says, up to the first step. Throws UsageError and RunError, alike
  /// on every rank. The arguments must outlive the run. Collective.
  Run(const Comm& comm, const Scene& scene, const RunOptions& options);
  ~Run();
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  const Comm& comm;
  const Scene& scene;
  const RunOptions& options;
  SimulationState state;
  StepReport last_step;  ///< undefined before the first
  std::unique_ptr<Solver> solver;
  std::unique_ptr<Balancer> balancer;
  RunClock clock;
  RunProgress progress;
  LastCheckpoint last_checkpoint;
  Watchdog watchdog;
  std::vector<std::unique_ptr<Output>> outputs;       ///< in the order in which they write
  std::vector<std::unique_ptr<StopCriterion>> stops;  ///< a later one wins over an earlier one

  bool at_end() const;
  /// The time that no step may cross: the next frame or the end, s.
  double next_landing() const;

  /// From its making to its end the write of `file` is watched, for checkpoint.timeout. Not collective.
  [[nodiscard]] Watchdog::Watch watch_write(const std::string& file);
  /// Likewise the start of a new run up to its first step, for time.step_timeout. Not collective.
  [[nodiscard]] Watchdog::Watch watch_start();
  /// Likewise the reading of a checkpoint and what follows until the first step, for checkpoint.timeout. Not collective.
  [[nodiscard]] Watchdog::Watch watch_restart();
  /// Likewise the step that begins and its output, for time.step_timeout. Not collective.
  [[nodiscard]] Watchdog::Watch watch_step();

  /// Of the particles as they are. Collective.
  Diagnostics diagnostics() const;

  /// Prints a line on the root unless the run is quiet. Not collective.
  void log(const std::string& text) const;
  /// Prints a warning on the root and keeps it for status.json. Not collective.
  void warn(const std::string& text);
  /// A clause that says which checkpoint there is, for messages. Not collective.
  std::string checkpoint_hint() const;
  /// As the last renewal of status.json knew phases and memory. Not collective.
  Status status(RunState run_state, const std::string& reason) const;
  /// Collective.
  HaloTraffic halo_traffic() const;

 private:
  /// s of wall time, that a step may take now; 0: as long as it likes.
  double step_limit() const;
  double longest_silence() const;
  GlobalIndex start();
  ParticleSet load(const std::string& file);
  GlobalIndex restore();
  void begin_energy_budget();
};

}  // namespace bulkley
