#pragma once
// Files that several ranks write at once, each to places of its own, without a call that waits for another rank.

#include <cstddef>
#include <functional>
#include <string>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// A file open for reading in places. Every member throws RunError. Not collective.
class PlacedReader {
 public:
  explicit PlacedReader(const std::string& path);
  ~PlacedReader();
  PlacedReader(const PlacedReader&) = delete;
  PlacedReader& operator=(const PlacedReader&) = delete;

  /// Reads `bytes` into `data` from `place` (bytes from the beginning) on.
  void read(void* data, GlobalIndex bytes, GlobalIndex place) const;

 private:
  const std::string path_;
  const int file_;
};

/// A file open for writing in places. Every member throws RunError. Not collective.
class PlacedFile {
 public:
  explicit PlacedFile(const std::string& path);
  ~PlacedFile();
  PlacedFile(const PlacedFile&) = delete;
  PlacedFile& operator=(const PlacedFile&) = delete;

  /// Writes `bytes` of `data` from `place` (bytes from the beginning) on.
  void write(const void* data, GlobalIndex bytes, GlobalIndex place) const;
  void sync() const;

 private:
  [[noreturn]] void fail(int error) const;
  const std::string path_;
  const int file_;
};

/// Creates `temporary`, which is to become `path`, empties it and reserves `bytes`: a clean refusal before anything is
/// written. Throws RunError. Not collective.
void make_room(const std::string& temporary, const std::string& path, GlobalIndex bytes);

/// Reserves the first `bytes` of a file that exists; a file system that cannot reserve is taken at its word that it has
/// room. Throws RunError, and then the file is gone. Not collective.
void reserve(const std::string& path, GlobalIndex bytes);

/// Writes `path`, of `bytes` in all, under a temporary name: every rank calls `work`, which writes its part and must not
/// communicate; then it is flushed to disk and renamed. Throws RunError on every rank, and what was there is untouched.
/// Collective.
void write_in_places(const Comm& comm, const std::string& path, GlobalIndex bytes,
                     const std::function<void(const PlacedFile&)>& work);

}  // namespace bulkley
