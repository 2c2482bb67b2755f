#pragma once
// How fast checkpoints and frames reach the disk and come back, compared with one process that writes and reads as many
// bytes.

#include <string>

#include "bulkley/parallel/comm.hpp"
#include "io/files/json_text.hpp"

namespace bulkley {

struct IoBench {
  std::string folder;                   ///< on the disk to be measured; made if needed, and left empty
  GlobalIndex n_particles = 1'000'000;  ///< over all ranks
  int n_rounds = 3;
};

/// Writes and reads a checkpoint of made-up particles, and writes a frame, in turn with a plain file of the checkpoint's
/// size (16 MiB at a time, then fsync; its caches are dropped before it is read). Medians over the rounds. Throws RunError
/// where the folder cannot be written. Collective.
Json bench_io(const Comm& comm, const IoBench& what);

}  // namespace bulkley
