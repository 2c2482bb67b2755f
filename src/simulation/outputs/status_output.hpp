#pragma once
// status.json during the run.

#include "simulation/outputs/output.hpp"

namespace bulkley {

class StatusOutput : public Output {
 public:
  Request wants(const Run& run) override;
  bool is_due(const Run& run, const Occasion& occasion) const override;
  void write(Run& run) override;

 private:
  double last_ = MPI_Wtime();         ///< the root's clock decides
  GlobalIndex checkpoint_step_ = -1;  ///< of the checkpoint that it told of last
};

/// Brings phases, memory and wall times up to date and writes status.json. Collective.
void renew_status(Run& run, RunState run_state, const std::string& reason);

}  // namespace bulkley
