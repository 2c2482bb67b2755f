#pragma once
// HDF5 files: written by all ranks together, read by each rank alone.
//
// Writing goes through the MPI-IO driver. Everything that changes the file's structure is collective; data go by independent
// writes to contiguous datasets, because collective data writes hang or silently lose data on a full disk
// (docs/architecture.md, "Files"). Reading is local work: a damaged file is then an ordinary local error that
// collective_guard can turn into the same sentence on every rank, where a collective open could hang.

#include <hdf5.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bulkley/base/parallel.hpp"

namespace bulkley {

/// Aborts all ranks with a message that names the failed call and HDF5's innermost reason. Not collective.
[[noreturn]] void abort_for_hdf5(const char* call, const char* file, int line);
/// `result` if it means success, else abort_for_hdf5.
template <class Result>
Result check_hdf5(Result result, const char* call, const char* file, int line) {
  if (static_cast<long long>(result) < 0) abort_for_hdf5(call, file, line);
  return result;
}
#define BULKLEY_HDF5(call) ::bulkley::check_hdf5((call), #call, __FILE__, __LINE__)

/// For local work, where a failure can be an ordinary error: RunError "`what`: HDF5's reason". Not collective.
[[noreturn]] void throw_for_hdf5(const std::string& what);
#define BULKLEY_HDF5_LOCAL(what, call) ::bulkley::check_hdf5_local((call), (what))
template <class Result>
Result check_hdf5_local(Result result, const std::string& what) {
  if (static_cast<long long>(result) < 0) throw_for_hdf5(what);
  return result;
}

/// Stops HDF5 from printing its error stack; our own messages quote it. Not collective.
void silence_hdf5();
/// HDF5's innermost reason for its last failure. Not collective.
std::string hdf5_reason();

/// Move-only owner of an HDF5 identifier.
template <herr_t (*Close)(hid_t)>
class HdfHandle {
 public:
  HdfHandle() = default;
  explicit HdfHandle(hid_t id) : id_(id) {}
  HdfHandle(HdfHandle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  HdfHandle& operator=(HdfHandle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  // A destructor has nobody to tell of a failure; the one close that can lose data is Hdf5Writer::close.
  ~HdfHandle() {
    if (id_ >= 0) Close(id_);
  }
  hid_t get() const { return id_; }
  hid_t release() { return std::exchange(id_, H5I_INVALID_HID); }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

using HdfFile = HdfHandle<H5Fclose>;
using HdfGroup = HdfHandle<H5Gclose>;
using HdfDataset = HdfHandle<H5Dclose>;
using HdfSpace = HdfHandle<H5Sclose>;
using HdfType = HdfHandle<H5Tclose>;
using HdfAttribute = HdfHandle<H5Aclose>;
using HdfList = HdfHandle<H5Pclose>;
using HdfObject = HdfHandle<H5Oclose>;

/// Element type of an array in a file; little-endian.
enum class ArrayType { float32, float64, int32, int64, uint8 };
std::size_t element_size(ArrayType type);
const char* name(ArrayType type);

using Extents = std::vector<GlobalIndex>;
/// Name of the n-th part (from 1) of a long text attribute.
std::string part_name(const std::string& name, int part);
/// Product of the extents; 1 for a scalar.
GlobalIndex n_elements(const Extents& shape);

using AttributeValue = std::variant<GlobalIndex, double, std::string, std::vector<double>>;

/// A new file, open for writing on all ranks.
class Hdf5Writer {
 public:
  /// Creates `path`, or empties it. Aborts all ranks on failure. Collective.
  Hdf5Writer(const Comm& comm, const std::string& path);

  /// Groups on the way are created too. Collective, same arguments on every rank.
  void create_group(const std::string& path);
  /// Sets or overwrites (same type and size) an attribute of a group or array. An attribute holds less than 64 KiB: longer
  /// text goes on in `name`_2, `name`_3, ... Collective, same arguments on every rank.
  void set_attribute(const std::string& object, const std::string& name, const AttributeValue& value);
  /// A contiguous dataset with its space in the file assigned at once and no fill values. Collective, same arguments.
  void create_array(const std::string& path, ArrayType type, const Extents& shape);
  /// Position in the file, in bytes, one past the last array. Not collective.
  GlobalIndex end_of_arrays() const { return end_of_arrays_; }

  /// Writes a block of an array. Blocks must stay below 2 GiB, the limit of one MPI-IO call. Throws RunError.
  /// Not collective.
  void write(const std::string& array, const Extents& start, const Extents& count, const void* data);

  /// Flushes and closes; aborts all ranks on failure, since HDF5 cannot be shut down in order after a failed close.
  /// Collective.
  void close();

 private:
  void set_one_attribute(const std::string& object, const std::string& name, const AttributeValue& value);

  std::string path_;
  HdfFile file_;
  HdfList independent_;
  GlobalIndex end_of_arrays_ = 0;
};

struct ArrayInfo {
  std::string path;
  ArrayType type;
  Extents shape;
};

/// A file open for reading on this rank. Every member throws RunError naming the file and the fault. Not collective.
class Hdf5Reader {
 public:
  explicit Hdf5Reader(const std::string& path);

  const std::string& path() const { return path_; }
  bool has(const std::string& object) const;
  bool has_attribute(const std::string& object, const std::string& name) const;
  GlobalIndex integer(const std::string& object, const std::string& name) const;
  double real(const std::string& object, const std::string& name) const;
  std::string text(const std::string& object, const std::string& name) const;
  std::vector<double> reals(const std::string& object, const std::string& name) const;
  AttributeValue attribute(const std::string& object, const std::string& name) const;
  /// Names of the attributes of an object, in order of name.
  std::vector<std::string> attribute_names(const std::string& object) const;
  /// Names of the members of a group, in order of name.
  std::vector<std::string> members(const std::string& group) const;
  ArrayInfo array(const std::string& path) const;
  /// Reads a block; the type must be that of the array.
  void read(const ArrayInfo& array, const Extents& start, const Extents& count, void* data) const;

 private:
  [[noreturn]] void fail(const std::string& fault) const;
  std::string damaged(const std::string& what) const;
  template <class Value>
  Value attribute_as(const std::string& object, const std::string& name, const char* kind) const;
  std::string path_;
  HdfFile file_;
};

}  // namespace bulkley
