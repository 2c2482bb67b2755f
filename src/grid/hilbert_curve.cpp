#include "grid/hilbert_curve.hpp"

#include <algorithm>
#include <bit>

namespace bulkley {

std::uint64_t hilbert_position(const Int3& at, int bits) {
  std::uint32_t x[3] = {static_cast<std::uint32_t>(at[0]), static_cast<std::uint32_t>(at[1]),
                        static_cast<std::uint32_t>(at[2])};
  // From the coarsest level down, the cube of each level is turned as the curve inside it is: axes are swapped or mirrored.
  for (std::uint32_t level = 1u << (bits - 1); level > 1; level >>= 1) {
    const std::uint32_t below = level - 1;
    for (std::uint32_t& coordinate : x) {
      if (coordinate & level) {
        x[0] ^= below;
      } else {
        const std::uint32_t differing = (x[0] ^ coordinate) & below;
        x[0] ^= differing;
        coordinate ^= differing;
      }
    }
  }
  // What is left is a Gray code of the position, its bits dealt to the axes in turn.
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t flips = 0;
  for (std::uint32_t level = 1u << (bits - 1); level > 1; level >>= 1)
    if (x[2] & level) flips ^= level - 1;
  std::uint64_t position = 0;
  for (int bit = bits - 1; bit >= 0; --bit)
    for (const std::uint32_t coordinate : x) position = position << 1 | (((coordinate ^ flips) >> bit) & 1u);
  return position;
}

// A cube little smaller than the grid is stretched over it, two layers of tiles sharing a layer of the curve here and there; in
// the next larger cube the last layers would come all by themselves, as one thin sheet.
HilbertCurve::HilbertCurve(const Int3& n_tiles)
    : widest_(static_cast<std::uint32_t>(std::max({n_tiles[0], n_tiles[1], n_tiles[2], 1}))) {
  const std::uint32_t smaller = std::bit_floor(widest_);
  const bool stretched = widest_ > smaller && 4 * widest_ <= 5 * smaller;
  width_ = stretched ? smaller : std::bit_ceil(widest_);
  bits_ = std::max(1, static_cast<int>(std::bit_width(width_ - 1)));
}

int HilbertCurve::coordinate(int tile) const {
  return width_ < widest_ ? static_cast<int>(static_cast<std::uint64_t>(tile) * width_ / widest_) : tile;
}

Int3 HilbertCurve::place(const Int3& tile) const {
  const Int3 at{coordinate(tile[0]), coordinate(tile[1]), coordinate(tile[2])};
  std::uint64_t position = hilbert_position(at, bits_);
  // Tiles that share a cell of a stretched cube follow each other; there are at most two along an axis.
  if (width_ < widest_)
    for (std::size_t a = 0; a < 3; ++a)
      position = position << 1 | static_cast<std::uint64_t>(tile[a] > 0 && coordinate(tile[a] - 1) == at[a]);
  constexpr std::uint64_t digit = (std::uint64_t{1} << digit_bits) - 1;
  return {static_cast<int>(position >> 2 * digit_bits), static_cast<int>(position >> digit_bits & digit),
          static_cast<int>(position & digit)};
}

}  // namespace bulkley
