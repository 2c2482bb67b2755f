#pragma once
// status.json: how a run stands, for job scripts; and the memory it takes.

#include <cstddef>
#include <string>

#include "bulkley/base/parallel.hpp"

namespace bulkley {

enum class RunState { running, stopped, failed, finished };
const char* name(RunState state);

struct Status {
  RunState state = RunState::running;
  GlobalIndex step = 0;
  double time = 0.0;       ///< s
  std::string checkpoint;  ///< newest whole one; empty: none
  std::string reason;      ///< why it stopped or failed; else empty
};

/// Writes `folder`/status.json (temporary name, then renamed) from the root's `status`. Throws RunError on every rank.
/// Collective.
void write_status(const Comm& comm, const std::string& folder, const Status& status);

/// Largest memory that this process has occupied so far, bytes. Not collective.
std::size_t peak_resident_bytes();

}  // namespace bulkley
