#pragma once
// Why a run ends before its end. A new reason is a class of its own and a line in stop_criteria_of.

#include <memory>
#include <string>
#include <vector>

#include "parallel/signals.hpp"
#include "simulation/run.hpp"

namespace bulkley {

class StopCriterion {
 public:
  virtual ~StopCriterion() = default;

  /// What this rank asks of the run with the step to come: to stop, or less. Called before every step. Clocks and files
  /// differ between ranks, so only the root should ask by them. Not collective.
  virtual Request wants(const Run& run) = 0;
  /// Why the run stopped, to follow "stopped", for example "by a signal". Not collective.
  virtual std::string reason(const Run& run) const = 0;
  /// The run has stopped for this reason and its checkpoint is written. Collective.
  virtual void obeyed(const Run& run) { (void)run; }
};

using StopCriteria = std::vector<std::unique_ptr<StopCriterion>>;

/// Wall time, the file STOP, signals; of several that want to stop the last one is given as the reason.
StopCriteria stop_criteria_of(const Run& run);

}  // namespace bulkley
