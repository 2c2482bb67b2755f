#pragma once
// What convert.hpp reads: the chosen columns and the chosen rows of a file's particles.

#include <cstdint>
#include <string>
#include <vector>

#include "io/arrays/hdf5_file.hpp"
#include "io/convert/convert.hpp"

namespace bulkley {

constexpr std::uint8_t vtk_vertex = 1;  ///< VTK_VERTEX, the type of the cells of particles in VTK's files

/// A field of the particles.
struct Column {
  std::string name;
  std::string unit;  ///< empty: none
  ArrayInfo array;
  int n_components = 1;
  GlobalIndex row_bytes() const { return n_components * static_cast<GlobalIndex>(element_size(array.type)); }
};

/// The particles of one file at one time.
struct Snapshot {
  double time = 0.0;  ///< s
  GlobalIndex step = 0;
  GlobalIndex n_particles = 0;
  Column position;
  std::vector<Column> fields;  ///< requested, in that order; otherwise: id first, then by name
};

/// Throws UsageError and RunError as convert_file. Not collective.
Snapshot read_moment(const Hdf5Reader& file, const Selection& selection);

/// The arrays that converting reads.
std::vector<std::string> arrays_read(const Snapshot& snapshot, const Selection& selection);

/// The selected rows of a part of a file.
class SelectedRows {
 public:
  /// Rows [first, last) of the file. `file` must outlive this. Throws RunError. Not collective.
  SelectedRows(const Hdf5Reader& file, const Snapshot& snapshot, const Selection& selection, GlobalIndex first,
               GlobalIndex last);

  GlobalIndex count() const { return before_.back(); }
  /// Values of rows [first, first + n) among those taken, one after the other. Throws RunError. Not collective.
  void read(const Column& column, GlobalIndex first, GlobalIndex n, std::byte* out) const;

 private:
  GlobalIndex block_end(GlobalIndex block) const;
  void read_block(const ArrayInfo& array, GlobalIndex block, std::vector<std::byte>& rows) const;
  void take(const std::vector<std::byte>& positions, const std::vector<std::byte>& ids, const Snapshot& snapshot,
            const Selection& selection, GlobalIndex block);

  const Hdf5Reader& file_;
  GlobalIndex first_, last_;
  std::vector<bool> taken_;          // of each row of the part
  std::vector<GlobalIndex> before_;  // rows taken before each block of the part, and in all
};

/// Of this rank: what it writes, and its place among all ranks.
struct Share {
  const Snapshot& snapshot;
  const SelectedRows& rows;
  GlobalIndex first = 0;  ///< rows taken by the ranks below
  GlobalIndex total = 0;  ///< by all ranks
};

/// Rows of a part at a time, so that `row_bytes` a row take a bounded piece of memory.
GlobalIndex rows_at_a_time(GlobalIndex row_bytes);

/// Collective.
void write_vtu(const Comm& comm, const std::string& path, const Share& share);
void write_vtkhdf(const Comm& comm, const std::string& path, const Share& share);
void write_csv(const Comm& comm, const std::string& path, const Share& share);

}  // namespace bulkley
