#pragma once
// From the first step of a run to its end.

#include "simulation/run.hpp"

namespace bulkley {

/// Takes steps and writes outputs until the end, or until a stop criterion asks to stop. Throws StepFailure and RunError,
/// alike on every rank. Collective.
RunOutcome run_to_end(Run& run);

}  // namespace bulkley
