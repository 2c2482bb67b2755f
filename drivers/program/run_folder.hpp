#pragma once
// The output folder of a run, running or ended, as a reader finds it who must not disturb it: nothing is written, locked or
// opened as HDF5, and what appears or vanishes meanwhile is no error.

#include <limits>
#include <string>
#include <vector>

#include "bulkley/base/types.hpp"
#include "parallel/phases.hpp"

namespace bulkley {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();  ///< of a figure that the files of a run do not tell

struct CheckpointFile {
  std::string path;
  GlobalIndex step = 0;
  double bytes = 0.0;
  double age = 0.0;  ///< s since it was written
};

/// Bytes and numbers of files by kind, of the folder and the folders in it.
struct DiskUse {
  double checkpoints = 0.0, frames = 0.0, rest = 0.0;  ///< bytes; sidecars count with their files
  GlobalIndex n_frames = 0;
  double total() const { return checkpoints + frames + rest; }
};

/// Contents of status.json and of the files in the folder. Numbers that are not in status.json are NaN.
struct RunFolder {
  std::string path;
  std::string state;              ///< of RunState, or "unknown"
  double step = 0.0, time = 0.0;  ///< time: s
  std::string reason, title, host, program, continuation;
  double end_time = 0.0;  ///< s
  double n_ranks = 0.0, n_particles = 0.0;
  double first_step = 0.0, first_time = 0.0;           ///< of the present part
  double elapsed = 0.0, stepping = 0.0, output = 0.0;  ///< s of wall time of the present part
  double peak_memory = 0.0;                            ///< bytes, largest of a rank
  double longest_silence = 0.0;       ///< s, within which it writes something or ends itself; 0: not bounded
  std::string last_checkpoint;        ///< as status.json has it
  double last_checkpoint_time = 0.0;  ///< s, simulated
  std::vector<PhaseSummary> phases;
  std::vector<std::string> warnings;
  std::vector<CheckpointFile> checkpoints;  ///< by ascending step
  DiskUse disk;
  double age = 0.0;  ///< s since something in the folder was written

  bool running() const { return state == "running"; }
  /// Says that it runs, but has written nothing for longer than a run does whose step takes `seconds_per_step`.
  bool silent(double seconds_per_step) const;
};

/// Throws UsageError, one sentence, when `path` is no folder, cannot be read or holds no run. Not collective.
RunFolder read_run_folder(const std::string& path);

}  // namespace bulkley
