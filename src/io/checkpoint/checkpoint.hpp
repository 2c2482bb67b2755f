#pragma once
// Checkpoints: everything a run needs to continue as if it had never stopped, on any number of ranks.
//
// One file, checkpoint_STEP.h5 (docs/architecture.md, "Files"): /particles holds every field that the field table marks as
// written, as (N), (N,3), (N,3,3) or (N,6: xx yy zz xy yz xz); the attributes of / hold the header; those of /state the
// controller's numbers; a force's fields on nodes are in a group of their own.

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "grid/box_fields.hpp"
#include "io/checkpoint/fingerprint.hpp"

namespace bulkley {

inline constexpr const char* checkpoint_format = "bulkley checkpoint";
/// Version of the layout; raised when an older program could not read a newer file.
inline constexpr GlobalIndex checkpoint_version = 1;

struct CheckpointHeader {
  GlobalIndex step = 0;
  double time = 0.0;       ///< s
  std::string scene_text;  ///< effective scene, TOML
  std::string code_version;
  int n_ranks = 0;                      ///< that wrote the file
  std::map<std::string, double> reals;  ///< kept bit for bit
  std::map<std::string, GlobalIndex> integers;
  GlobalIndex n_particles = 0;              ///< over all ranks; set by the functions below
  std::vector<std::string> material_names;  ///< set by the functions below
  /// Of each field, by name; set by the functions below. Files of earlier versions have none.
  std::map<std::string, Fingerprint> fingerprints;
};

/// Writes `folder`/checkpoint_STEP.h5 and its XDMF sidecar, then removes the oldest checkpoints beyond the `keep` newest
/// up to this step, and leftovers of interrupted writes. `boxes`: further fields, on nodes. The root's header is the one that
/// counts; its n_ranks is set to the number of ranks. Throws RunError, also when a particle fails verify_checkpoint, and then older
/// checkpoints are all still there. Collective.
void write_checkpoint(const Comm& comm, const std::string& folder, const CheckpointHeader& header,
                      const ParticleSet& particles, std::span<const std::string> material_names, int keep,
                      std::span<const BoxFields> boxes = {});

/// Bytes of a checkpoint of `n_particles` that have these optional fields, but for some kilobytes of header. Not collective.
GlobalIndex checkpoint_bytes(const OptionalFields& fields, GlobalIndex n_particles);

/// Path of the checkpoint of a step. Not collective.
std::string checkpoint_path(const std::string& folder, GlobalIndex step);

/// Header of a checkpoint, after checking its format, version, header checksum and the type and shape of every array. Throws
/// RunError with one sentence that names the file and the fault. Collective.
CheckpointHeader read_header(const Comm& comm, const std::string& file);

/// read_header, the checksums of all arrays, and the particles: finite numbers, materials of the file, ids that are not
/// negative, and the fingerprints of the header, which prove that ids and values are those of the particles that were written;
/// that ids occur once, in a file without fingerprints. The header has those of all fields. Throws RunError. Collective.
CheckpointHeader verify_checkpoint(const Comm& comm, const std::string& file);

/// Replaces `particles` by particles [first, first + count) of the file, in the order of the file. The ranks' parts must
/// follow each other in rank order and make up the whole file, so that the checksums are verified on the way. Fields that
/// are not written are zero. A file may lack kirchhoff_stress, which follows from the strain: false where particles store it and the
/// file does. Checks what verify_checkpoint checks. Throws RunError. Collective.
bool read_checkpoint(const Comm& comm, const std::string& file, GlobalIndex first, GlobalIndex count,
                     ParticleSet& particles);

/// read_box (io/arrays/box_array.hpp) of a checkpoint whose checksums read_checkpoint has compared. Throws RunError. Collective.
bool read_box(const Comm& comm, const std::string& file, BoxFields& box);

/// The newest whole checkpoint in `folder`, every checksum verified. A damaged newer one is passed over with a sentence in
/// `warnings`; none at all gives nothing. Collective.
std::optional<std::string> find_latest_checkpoint(const Comm& comm, const std::string& folder,
                                                  std::vector<std::string>& warnings);

/// Calls `read` with the newest checkpoint in `folder`; while it throws RunError, which becomes a sentence in `warnings`,
/// with the one before. The file that was read, if any. `read` must behave in the same way on every rank. Collective.
std::optional<std::string> read_latest_checkpoint(const Comm& comm, const std::string& folder,
                                                  std::vector<std::string>& warnings,
                                                  const std::function<void(const std::string& file)>& read);

/// Removes checkpoints (and sidecars) of steps greater than `step`: after a restart from an older one, or a fresh start
/// (step = -1) in a used folder, they belong to another run. Then does what a killed writer has left undone: of the others the
/// `keep` newest stay, each with its sidecar. Returns how many later ones were removed. Collective.
int remove_checkpoints_after(const Comm& comm, const std::string& folder, GlobalIndex step, int keep);

/// What a checkpoint or frame holds, as human-readable text; verifies all its checksums. Throws RunError. Collective.
std::string describe_file(const Comm& comm, const std::string& file);

}  // namespace bulkley
