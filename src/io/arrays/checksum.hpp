#pragma once
// CRC-32 of arrays that are written in blocks by several ranks.

#include <zlib.h>

#include <cstddef>
#include <span>
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

/// What a rank's runs, with their CRCs, add to the CRC-32 of an array of `array_bytes`: the exclusive or of the parts of all
/// ranks is that of the whole array, in whatever order they come. Not collective.
std::uint32_t crc_part(const Runs& runs, const std::vector<std::uint32_t>& crcs, GlobalIndex array_bytes);

/// The CRC-32 of each array from the ranks' parts, the same on every rank: one reduction. Collective.
void combine_parts(const Comm& comm, std::vector<std::uint32_t>& parts);

/// The same from pieces that follow each other in rank order. Collective.
std::vector<std::uint32_t> combine_pieces(const Comm& comm, std::span<const Piece> pieces);

}  // namespace bulkley
