#pragma once
// Checkpoints: by steps, by the clock, on request, and when the run stops or ends.

#include "simulation/outputs/output.hpp"

namespace bulkley {

class CheckpointOutput : public Output {
 public:
  Request wants(const Run& run) override;
  bool is_due(const Run& run, const Occasion& occasion) const override;
  void write(Run& run) override;
};

}  // namespace bulkley
