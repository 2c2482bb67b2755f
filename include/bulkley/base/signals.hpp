#pragma once
// Stop requests from outside the program.

namespace bulkley {

/// What a rank asks of the run; larger is stronger, so a maximum over ranks decides.
enum class Request : int {
  none = 0,
  checkpoint = 1,  ///< write a checkpoint and go on (SIGUSR2)
  stop = 2,        ///< write a checkpoint and stop (SIGTERM, SIGINT, SIGUSR1)
};

/// Installs the handlers; they only set a flag. Call after PetscInitialize, which takes other signals. Not collective.
void watch_signals();

/// The strongest request since the last call; a request to stop stays. Not collective.
Request pending_request();

}  // namespace bulkley
