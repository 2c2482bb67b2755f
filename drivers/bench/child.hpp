#pragma once
// Runs of this program on other rank counts, started by one of its processes.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/files/json_text.hpp"

namespace bulkley {

/// Keeps the environment for child processes; to be called before MPI is initialised, which adds to it what would make a
/// child believe it was a rank of the same job.
void remember_environment();

/// Why no run on `n_ranks` ranks can be started from here, as a clause; empty when it can. One rank needs no mpirun.
std::string child_obstacle(int n_ranks);

struct ChildOutcome {
  std::string fault;  ///< empty, or what went wrong, as a clause
  Json json;          ///< what the child wrote
};

/// `bulkley bench arguments --json FILE` on `n_ranks` ranks, ended after `time_limit` seconds. Sleeps meanwhile. Not
/// collective.
ChildOutcome run_child_bench(int n_ranks, const std::vector<std::string>& arguments, double time_limit);

}  // namespace bulkley
