#include "simulation/outputs/status_output.hpp"

#include <algorithm>

#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

// status.json is renewed once the program has run as long again, then at the longer interval: each costs a flush to disk.
constexpr double shortest_interval = 5.0, longest_interval = 20.0;  // s

}  // namespace

Request StatusOutput::wants(const Run& run) {
  if (!run.comm.is_root()) return Request::none;
  const double now = MPI_Wtime();
  const double interval = std::clamp(now - run.clock.start, shortest_interval, longest_interval);
  return now - last_ >= interval ? Request::status : Request::none;
}

bool StatusOutput::is_due(const Run& run, const Occasion& occasion) const {
  return occasion.event == RunEvent::start || occasion.asked == Request::status ||
         run.last_checkpoint.step != checkpoint_step_;
}

void StatusOutput::write(Run& run) {
  renew_status(run, RunState::running, "");
  checkpoint_step_ = run.last_checkpoint.step;
  last_ = MPI_Wtime();
}

void renew_status(Run& run, RunState run_state, const std::string& reason) {
  const auto watch = run.watch_write(path_in(run.options.folder, "status.json"));
  update_progress(run.comm, run.state, run.clock, run.solver->times(), run.progress);
  write_status(run.comm, run.options.folder, run.status(run_state, reason));
}

}  // namespace bulkley
