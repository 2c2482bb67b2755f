#pragma once
// Stop requests from outside the program.

namespace bulkley {

/// What a rank asks of the run; larger is stronger, so a maximum over ranks decides.
enum class Request : int {
  none = 0,
  status = 1,      ///< renew status.json
  checkpoint = 2,  ///< write a checkpoint, and status.json with it, and continue (SIGUSR2)
  stop = 3,        ///< write a checkpoint and stop (SIGTERM, SIGINT, SIGUSR1)
};

/// Installs the handlers; they only set a flag, so that a signal may come again, or at any time. MPI and PETSc (with
/// -no_signal_handler) leave these signals alone: call it first thing, before they start. Not collective.
void watch_signals();

/// The strongest request since the last call; a request to stop stays. Not collective.
Request pending_request();

/// Whether SIGTERM has come, which launchers send before they kill. Any thread may ask. Not collective.
bool told_to_end();

}  // namespace bulkley
