#pragma once
// CRC-32 of arrays that are written in blocks by several ranks.

#include <zlib.h>

#include <cstddef>
#include <vector>

#include "io/arrays/array_file.hpp"

namespace bulkley {

inline std::uint32_t crc_of(const std::byte* data, std::size_t bytes, std::uint32_t so_far = 0) {
  return static_cast<std::uint32_t>(crc32_z(so_far, reinterpret_cast<const Bytef*>(data), bytes));
}

/// The runs of a block: its largest pieces that are contiguous in the file, in the order of the file.
struct Runs {
  GlobalIndex length = 0;            ///< bytes of each run
  std::vector<GlobalIndex> offsets;  ///< bytes from the start of the array
};
Runs runs_of(const Array& array);

/// Checksums of the runs of a block whose bytes come in order, in portions of any size.
class RunChecksums {
 public:
  explicit RunChecksums(GlobalIndex run_length) : run_length_(run_length) {}
  void add(const std::byte* data, GlobalIndex bytes);
  const std::vector<std::uint32_t>& values() const { return values_; }

 private:
  GlobalIndex run_length_;
  GlobalIndex filled_ = 0;  ///< bytes in the last run
  std::vector<std::uint32_t> values_;
};

/// CRC-32 of a whole array from the runs of all ranks; the same on every rank. Collective.
std::uint32_t combine_runs(const Comm& comm, const Runs& runs, const std::vector<std::uint32_t>& crcs);

}  // namespace bulkley
