#pragma once
// An HDF5 file of arrays that is there whole and checked, or not at all; what checkpoints and frames have in common.
//
// Writing: the root makes an HDF5 file with all its structure and reserves the room; every rank then writes its block of
// every array by itself, straight to where HDF5 has put the array; a CRC-32 of each array, the same on any number of ranks,
// is kept as its attribute `crc32`; the file is flushed to disk, read back and compared, and only then given its name. No
// call waits for another rank, so that a disk that fails one of them is an error on all and no hang.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/arrays/hdf5_file.hpp"
#include "io/files/placed_file.hpp"

namespace bulkley {

/// One array of a new file and this rank's block of it.
struct Array {
  std::string path;
  ArrayType type = ArrayType::float64;
  Extents shape;         ///< of the whole array; at least one axis
  Extents start, count;  ///< this rank's block; the blocks of all ranks tile the array
  std::string unit;
  std::string meaning;
  /// Fills `out` with planes [first, first + n) of the block's first axis, row-major. Must not communicate.
  std::function<void(GlobalIndex first, GlobalIndex n, std::byte* out)> fill;
};

/// Bytes of the whole array, uncompressed.
GlobalIndex stored_bytes(const Array& array);

struct Attribute {
  std::string object;  ///< group; created if need be
  std::string name;
  AttributeValue value;
};

/// What a file holds. The same on every rank but for the blocks of the arrays.
struct FileContent {
  std::string format;
  GlobalIndex format_version = 0;
  std::vector<Attribute> attributes;
  std::vector<Array> arrays;
  int deflate_level = 0;  ///< of the arrays, 1 to 9; 0: as they are
};

/// Writes `path`, or leaves what was there untouched. Throws RunError on every rank when there is no room, a rank cannot
/// write, or the file does not read back as written. Collective.
void write_array_file(const Comm& comm, const std::string& path, const FileContent& content);

/// The CRC-32 and size of a piece of an array.
struct Piece {
  std::uint32_t crc = 0;
  GlobalIndex bytes = 0;
};

/// Refuses a file whose format is not `format` or whose format_version is greater than `newest_version`. Throws RunError.
/// Not collective.
void check_format(const Hdf5Reader& file, const std::string& format, GlobalIndex newest_version);

/// An array of a file as the root has found it.
struct StoredArray {
  ArrayInfo info;
  GlobalIndex place = -1;  ///< Hdf5Reader::place
  std::uint32_t crc = 0;   ///< stored
};

/// The arrays of `path` that `choose` names, on every rank. The root alone opens the file, and calls `choose`. Throws RunError.
/// Collective.
std::vector<StoredArray> find_arrays(const Comm& comm, const std::string& path,
                                     const std::function<std::vector<std::string>(const Hdf5Reader&)>& choose);

/// Reads rows of the arrays of one file on this rank: past HDF5 where they have a place, so that it is not HDF5 on every rank
/// that looks through the whole structure of the file. Every member throws RunError. Not collective.
class RowReader {
 public:
  explicit RowReader(const std::string& path) : path_(path) {}

  /// Reads rows [first, first + n) of the first axis, some at a time, into `sink(row, n_rows, bytes)`; `row` counts from
  /// `first`.
  Piece read(const StoredArray& array, GlobalIndex first, GlobalIndex n,
             const std::function<void(GlobalIndex, GlobalIndex, const std::byte*)>& sink);

 private:
  const std::string path_;
  std::optional<PlacedReader> places_;  ///< both opened when needed
  std::optional<Hdf5Reader> file_;
};

/// Reads this rank's even share of an array. Throws RunError. Not collective.
Piece read_share(const Comm& comm, RowReader& reader, const StoredArray& array);

/// Compares the stored checksums with those of the ranks' pieces of each array, which follow each other in rank order. Throws
/// RunError naming the file and the first array that differs. Collective.
void check_pieces(const Comm& comm, const std::string& path, std::span<const StoredArray> arrays,
                  std::span<const Piece> pieces);

/// Reads the arrays of `path` on all ranks, a part each, and compares their checksums. Throws RunError. Collective.
void verify_arrays(const Comm& comm, const std::string& path, const std::vector<std::string>& names);

/// The stored checksum of an array. Not collective.
std::uint32_t stored_crc(const Hdf5Reader& file, const std::string& array);

}  // namespace bulkley
