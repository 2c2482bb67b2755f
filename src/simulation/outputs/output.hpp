#pragma once
// What a run writes while it runs. A new output is a class of its own and a line in outputs_of.

#include <memory>
#include <vector>

#include "parallel/signals.hpp"
#include "simulation/run.hpp"

namespace bulkley {

enum class RunEvent {
  start,  ///< before the first step, also after a restart
  step,   ///< a step was taken
  stop,   ///< the run ends early and shall be continued
  end,    ///< it has reached its end
};

/// When an output is asked whether it is due: the same on every rank.
struct Occasion {
  RunEvent event;
  Request asked;  ///< by some rank with the step
};

class Output {
 public:
  virtual ~Output() = default;

  /// What this rank asks of all for the step to come; it comes back as Occasion::asked, the strongest of all ranks'. Clocks
  /// differ, so only the root should ask by the clock. Not collective.
  virtual Request wants(const Run& run) {
    (void)run;
    return Request::none;
  }
  /// Whether to write now. Must be the same on every rank if `write` is collective. Not collective.
  virtual bool is_due(const Run& run, const Occasion& occasion) const = 0;
  /// Throws RunError, the same on every rank. Collective unless the class says otherwise.
  virtual void write(Run& run) = 0;
  /// What was written so far is to be as durable as the checkpoint that comes next. Collective.
  virtual void make_durable(Run& run) { (void)run; }
};

using Outputs = std::vector<std::unique_ptr<Output>>;

/// Those of a run, in the order in which they write. `restart_step`: what earlier parts of the run wrote after this step is
/// taken back; -1 at a fresh start. Collective.
Outputs outputs_of(Run& run, GlobalIndex restart_step);

/// Writes what is due. Collective.
void write_outputs(Run& run, const Occasion& occasion);

}  // namespace bulkley
