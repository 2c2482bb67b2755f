#pragma once
// One run from its scene to its end: seeding or restart, the time loop, output, checkpoints, stop requests.

#include <string>

#include "bulkley/parallel/comm.hpp"
#include "scene/scene.hpp"

namespace bulkley {

struct RunOptions {
  std::string folder;          ///< where everything is written; created
  bool restart = false;        ///< continue from a checkpoint
  std::string restart_file;    ///< empty: the newest whole checkpoint of `folder`
  bool changed_scene = false;  ///< continue although the scene differs from the checkpoint's
  bool overwrite = false;      ///< delete an earlier run in `folder` instead of refusing
  GlobalIndex max_steps = -1;  ///< stop after this step number; < 0: no bound
  double max_walltime = 0.0;   ///< s from `begin`; 0: no bound
  double begin = 0.0;          ///< when the program began, MPI_Wtime
  std::string continuation;    ///< command that continues the run, without its launcher; for the user to read
  std::string program;         ///< version of the program and its libraries, for status.json
  bool quiet = false;          ///< no progress lines
};

enum class RunOutcome {
  finished,  ///< the end time or max_steps
  stopped,   ///< signal, file STOP or wall time, with a good checkpoint
};

/// Runs `scene`. Throws UsageError (folder in use, nothing to restart from, a checkpoint of another scene) and RunError,
/// the same on every rank; status.json tells the outcome, except of a UsageError: that run has not begun. Collective.
RunOutcome run_simulation(const Comm& comm, const Scene& scene, const RunOptions& options);

}  // namespace bulkley
