#pragma once
// Particles of a frame or checkpoint for programs that read neither: VTK files and tables as text.
//
// Every rank reads and writes an equal part of the file's rows, in blocks; the bytes of what is written are the same on any
// number of ranks. Rows keep the order of the file.

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "geometry/shape.hpp"

namespace bulkley {

enum class ConvertFormat {
  vtu,     ///< VTK's XML file of an unstructured grid, binary data appended
  vtkhdf,  ///< VTK's HDF5 file of an unstructured grid, version 1.0
  csv,     ///< a header with names and units, and one line a particle
};

/// What of a file is wanted.
struct Selection {
  std::vector<std::string> fields;  ///< in addition to the position; empty: all
  Bounds region{Vec3::Constant(-std::numeric_limits<double>::infinity()),
                Vec3::Constant(std::numeric_limits<double>::infinity())};  ///< m; lower <= position < upper
  GlobalIndex every = 1;  ///< about one particle in so many, chosen by their ids (is_chosen)
};

/// Whether a particle is of the one in `every` that is kept: by a hash of its id, since ids themselves follow the pattern
/// of the seeding. The same at all times and on any number of ranks. Not collective.
bool is_chosen(GlobalIndex id, GlobalIndex every);

/// What was written, the same on every rank.
struct Conversion {
  double time = 0.0;  ///< s
  GlobalIndex n_particles = 0;
  GlobalIndex n_written = 0;
};

/// Writes the selected particles of `input`, whose checksums are verified, to `output`, which appears whole or not at all.
/// Memory: some blocks of 16 MiB and one bit per particle of a rank's part. Throws UsageError for a file that is neither
/// frame nor checkpoint, or does not have the requested fields; RunError for one that is damaged, and when `output` cannot
/// be written. Collective.
Conversion convert_file(const Comm& comm, const std::string& input, const std::string& output, ConvertFormat format,
                        const Selection& selection);

struct SeriesEntry {
  std::string file;  ///< name without folder
  double time = 0.0;
};

/// ParaView's list of VTK files with their times. Text only; not collective.
std::string pvd_document(std::span<const SeriesEntry> entries);

}  // namespace bulkley
