#include "simulation/outputs/output.hpp"

#include "simulation/outputs/checkpoint_output.hpp"
#include "simulation/outputs/frame_output.hpp"
#include "simulation/outputs/history_output.hpp"
#include "simulation/outputs/progress_output.hpp"
#include "simulation/outputs/status_output.hpp"

namespace bulkley {

Outputs outputs_of(Run& run, GlobalIndex restart_step) {
  Outputs outputs;
  outputs.push_back(std::make_unique<FrameOutput>(run, restart_step));
  outputs.push_back(std::make_unique<HistoryOutput>(run, restart_step));
  outputs.push_back(std::make_unique<ProgressOutput>());
  outputs.push_back(std::make_unique<CheckpointOutput>());
  outputs.push_back(std::make_unique<StatusOutput>());  // last: it names a checkpoint just written
  return outputs;
}

void write_outputs(Run& run, const Occasion& occasion) {
  for (const auto& output : run.outputs)
    if (output->is_due(run, occasion)) output->write(run);
}

}  // namespace bulkley
