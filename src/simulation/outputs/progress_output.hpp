#pragma once
// Lines on stdout: how far the run is.

#include "simulation/outputs/output.hpp"

namespace bulkley {

class ProgressOutput : public Output {
 public:
  bool is_due(const Run& run, const Occasion& occasion) const override {
    return occasion.event == RunEvent::step && MPI_Wtime() - last_ >= run.scene.output.progress_interval;
  }
  /// Not collective.
  void write(Run& run) override {
    last_ = MPI_Wtime();
    run.log(progress_line(run.state, run.last_step.plan, run.scene.time_stepping.end_time, run.clock, run.comm.size()));
  }

 private:
  double last_ = MPI_Wtime();
};

}  // namespace bulkley
