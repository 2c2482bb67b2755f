#pragma once
// HDF5 files: made by one process, read by each rank alone.
//
// No call of HDF5 is collective: what a file system answers to one rank is then an ordinary local error, which
// collective_guard turns into the same sentence on every rank. HDF5's collective calls hang where a rank cannot write
// (docs/architecture.md, "Files"). All ranks write at once all the same: see array_file.hpp.

#include <hdf5.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bulkley/parallel/comm.hpp"

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
  // A destructor cannot report a failure; the one close that can lose data is Hdf5Writer::close.
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

/// Text that other programs expect to be marked as ASCII; ours is marked as UTF-8. Written only: it is read as std::string.
struct AsciiText {
  std::string text;
};
using AttributeValue =
    std::variant<GlobalIndex, double, std::string, std::vector<double>, AsciiText, std::vector<GlobalIndex>>;

/// The structure of a file: groups, attributes, and arrays whose values are written past HDF5. Every member throws RunError
/// naming the file. Not collective.
class Hdf5Writer {
 public:
  enum class Mode { create, change };
  /// Creates `path`, or empties it; or opens it to change attributes.
  Hdf5Writer(const std::string& path, Mode mode);

  /// Groups on the way are created too.
  void create_group(const std::string& path);
  /// Sets or overwrites (same type and size) an attribute of a group or array. An attribute holds less than 64 KiB: longer
  /// text continues in `name`_2, `name`_3, ...
  void set_attribute(const std::string& object, const std::string& name, const AttributeValue& value);
  /// A contiguous dataset with its space in the file assigned at once and no fill values. Where its values begin in the
  /// file, bytes; 0 if it has none.
  GlobalIndex create_array(const std::string& path, ArrayType type, const Extents& shape);
  /// A dataset of compressed chunks, for write_block. `deflate_level`: 1 to 9. Precondition: the array is not empty.
  void create_compressed(const std::string& path, ArrayType type, const Extents& shape, int deflate_level);
  /// Writes a block of an array.
  void write_block(const std::string& array, const Extents& start, const Extents& count, const void* data);

  /// Flushes and closes. What is not closed so is lost. Aborts all ranks if HDF5 cannot close the file: it could not be shut
  /// down in order after that.
  void close();
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

 private:
  void close_file();
  void set_one_attribute(const std::string& object, const std::string& name, const AttributeValue& value);
  std::string what() const;

  std::string path_;
  HdfFile file_;
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
  std::vector<GlobalIndex> integers(const std::string& object, const std::string& name) const;
  AttributeValue attribute(const std::string& object, const std::string& name) const;
  /// Names of the attributes of an object, in order of name.
  std::vector<std::string> attribute_names(const std::string& object) const;
  /// Names of the members of a group, in order of name.
  std::vector<std::string> members(const std::string& group) const;
  ArrayInfo array(const std::string& path) const;
  /// Where the values of an array begin in the file, bytes, if they lie there as in memory and one after the other; -1 where only
  /// HDF5 can read them.
  GlobalIndex place(const ArrayInfo& array) const;
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
