#pragma once
// A Hilbert curve through the tiles of a grid.

#include <cstdint>

#include "bulkley/base/types.hpp"

namespace bulkley {

/// Position along the Hilbert curve of order `bits` of the cube cell `at` (0 <= at < 2^bits along each axis, bits <= 20):
/// cells that follow each other share a face. After Skilling (2004), "Programming the Hilbert curve".
std::uint64_t hilbert_position(const Int3& at, int bits);

/// The curve through a grid of tiles. No function is collective.
class HilbertCurve {
 public:
  static constexpr int digit_bits = 19;  ///< enough for the tiles along an axis: a grid has at most 2^20 cells there

  HilbertCurve() = default;
  explicit HilbertCurve(const Int3& n_tiles);

  /// Where a tile lies on the curve: three digits of `digit_bits`, the leading one first, different for any two tiles. Compared
  /// in lexicographic order they follow the curve.
  Int3 place(const Int3& tile) const;

  bool operator==(const HilbertCurve&) const = default;

 private:
  int coordinate(int tile) const;  // of the cube that the curve fills

  std::uint32_t widest_ = 1, width_ = 1;  // tiles along the longest axis; of the cube
  int bits_ = 1;
};

}  // namespace bulkley
