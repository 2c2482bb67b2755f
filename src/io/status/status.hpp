#pragma once
// status.json: progress of a run, for job scripts; and its memory.

#include <cstddef>
#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "parallel/phases.hpp"

namespace bulkley {

enum class RunState { running, stopped, failed, finished };
const char* name(RunState state);

/// How the implicit pressure was found, between two rows of history.csv.
struct PressureFigures {
  double iterations = 0.0;  ///< a step
  GlobalIndex most_iterations = 0;
  double contact_rounds = 0.0;  ///< a step
};

/// How the viscous motion is found, where viscosity is implicit.
struct ViscosityFigures {
  double iterations = 0.0;  ///< a step
  GlobalIndex most_iterations = 0;
};

/// What the run is, and what its present part, since the start of the program, has cost so far.
struct RunProgress {
  std::string title;    ///< of the scene
  std::string program;  ///< what `bulkley --version` prints
  std::string host;     ///< of the root
  std::string started;  ///< when this part began, UTC to the microsecond, the same on every rank: tells it from other parts
  int n_ranks = 0;      ///< 0: not known yet
  GlobalIndex n_particles = 0;
  double end_time = 0.0;         ///< s
  GlobalIndex first_step = 0;    ///< that this part began from
  double first_time = 0.0;       ///< s, that this part began from
  double elapsed = 0.0;          ///< s of wall time
  double stepping = 0.0;         ///< s of it in steps
  double output = 0.0;           ///< s of it in frames, history and checkpoints
  double peak_memory = 0.0;      ///< bytes, largest of a rank
  double checkpoint_time = 0.0;  ///< s, simulated time of the newest checkpoint
  double longest_silence = 0.0;  ///< s of wall time within which the run writes something or ends itself; 0: not bounded
  PressureFigures pressure;      ///< of the last row of history.csv
  ViscosityFigures viscosity;    ///< likewise
  double volume_error = 0.0;     ///< likewise
  std::string continuation;      ///< command that continues the run
  std::vector<PhaseSummary> phases;
  std::vector<std::string> warnings;
};

struct Status {
  RunState state = RunState::running;
  GlobalIndex step = 0;
  double time = 0.0;       ///< s
  std::string checkpoint;  ///< newest whole one; empty: none
  std::string reason;      ///< why it stopped or failed; else empty
  RunProgress progress;
  bool unresponsive = false;  ///< it failed because of the machine, and can go on from its checkpoint
  bool in_set_up = false;     ///< it failed before its first step: the folder holds nothing to continue or to lose
};

/// Writes `folder`/status.json (temporary name, then renamed) from the root's `status`. Throws RunError on every rank.
/// Collective.
void write_status(const Comm& comm, const std::string& folder, const Status& status);

/// As write_status, by one process alone. Throws RunError. Not collective.
void write_status_alone(const std::string& folder, const Status& status);

/// Turns the status.json of `folder` into that of a run that failed for `reason`, `unresponsive` as in Status; all else stays, also the
/// step and checkpoint of an earlier part. False if there is no status. Throws RunError. Not collective.
bool mark_failed_alone(const std::string& folder, const std::string& reason, bool unresponsive);

/// Whether the status.json of `folder` says already why the part that began at `started` has failed. Who knows the cause speaks first;
/// that others end is what follows from it. Not collective.
bool says_failed(const std::string& folder, const std::string& started);

/// Writes `status`, of a failure, unless says_failed. By `rank` alone; others may do so at once. Throws RunError. Not collective.
void write_first_failure_alone(const std::string& folder, const Status& status, int rank);

/// Turns the status.json of `folder` into that of a run that failed because a rank or the machine did not answer: state
/// "failed", `reason`, `started`, and "unresponsive": true, from which job scripts know that it can go on from its checkpoint;
/// nothing if says_failed. By `rank` alone; others may do so at once. Throws RunError. Not collective.
void mark_unresponsive_alone(const std::string& folder, const std::string& reason, const std::string& started, int rank);

/// Now, UTC to the microsecond, as 2026-01-31T12:00:00.000000Z. Not collective.
std::string time_stamp();

/// Largest memory that this process has occupied so far, bytes. Not collective.
std::size_t peak_resident_bytes();

}  // namespace bulkley
