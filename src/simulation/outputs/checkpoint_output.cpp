#include "simulation/outputs/checkpoint_output.hpp"

#include <fmt/format.h>

#include "bulkley/version.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

Request CheckpointOutput::wants(const Run& run) {
  const double interval = run.scene.checkpoint.wall_interval;
  const bool is_time = run.comm.is_root() && interval > 0.0 && MPI_Wtime() - run.last_checkpoint.wall_time >= interval;
  return is_time ? Request::checkpoint : Request::none;
}

bool CheckpointOutput::is_due(const Run& run, const Occasion& occasion) const {
  if (run.last_checkpoint.step == run.state.step) return false;
  const GlobalIndex interval = run.scene.checkpoint.step_interval;
  switch (occasion.event) {
    case RunEvent::start:
      return false;
    case RunEvent::step:
      return occasion.asked == Request::checkpoint || (interval > 0 && run.state.step % interval == 0);
    case RunEvent::stop:
      return true;
    case RunEvent::end:
      return run.scene.checkpoint.at_end || run.options.max_steps >= 0;
  }
  return false;
}

void CheckpointOutput::write(Run& run) {
  const double before = MPI_Wtime();
  SimulationState& state = run.state;
  const std::string file = checkpoint_path(run.options.folder, state.step);
  const auto watch = run.watch_write(file);
  for (const auto& output : run.outputs) output->make_durable(run);
  CheckpointHeader header;
  header.step = state.step;
  header.time = state.time;
  header.scene_text = run.scene.effective_text;
  header.code_version = fmt::format("{} ({})", version, git_commit);
  state.contact_impulses = run.solver->contact_impulses().words();
  state.energy_words = run.solver->energy_words();
  run.solver->save_forces(state.force_reals, state.force_integers);
  save_state(state, header.reals, header.integers);
  const std::vector<BoxFields> boxes = run.solver->save_force_fields();
  write_checkpoint(run.comm, run.options.folder, header, run.solver->particles(), material_names(run.scene),
                   run.scene.checkpoint.keep, boxes);
  const double now = MPI_Wtime();
  run.last_checkpoint = {file, state.step, now, now - before};
  run.progress.checkpoint_time = state.time;
  run.clock.output += now - before;
}

}  // namespace bulkley
