#pragma once
// The output folder of a run: made ready before it, told of a failure after it.

#include <string>

#include "io/status/status.hpp"
#include "simulation/simulation.hpp"

namespace bulkley {

/// The folder exists then, for every rank, holds no other run and no leftovers. Throws UsageError or RunError on every rank.
/// Collective.
void prepare_folder(const Comm& comm, const RunOptions& options);

/// Tells of a run that could not be set up. A new run's folder then holds a status.json that the next run in it replaces; of a run
/// that was to be continued, step and checkpoint stay. Collective.
void write_set_up_failure(const Comm& comm, const Scene& scene, const RunOptions& options, const std::string& reason);
/// As write_set_up_failure, by one process alone; `unresponsive` as in Status. Throws RunError. Not collective.
void write_set_up_failure_alone(const Comm& comm, const Scene& scene, const RunOptions& options, const std::string& reason,
                                bool unresponsive);

/// Tells job scripts of a failure. The disk may be what failed: then a line says so, for the sentence that is on its way to
/// the user counts more. Collective.
void write_failure(const Comm& comm, const std::string& folder, const Status& status);

}  // namespace bulkley
