#include "balance/hilbert.hpp"

#include <algorithm>
#include <bit>

#include "balance/ranges.hpp"

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

std::vector<std::int32_t> hilbert_parts(const GridGeometry& grid, const TileLoad& load, int n_parts) {
  // A cube little smaller than the grid is stretched over it, some layers of tiles sharing a layer of the curve; in the next
  // larger cube the last layers would come all by themselves, as one thin sheet.
  const auto widest = static_cast<std::uint32_t>(std::max({grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)}));
  const std::uint32_t smaller = std::bit_floor(widest);
  const bool stretched = widest > smaller && 4 * widest <= 5 * smaller;
  const int bits = std::max(1, static_cast<int>(std::bit_width(stretched ? smaller - 1 : widest - 1)));
  const auto on_curve = [&](int tile) {
    return stretched ? static_cast<int>(static_cast<std::uint64_t>(tile) * smaller / widest) : tile;
  };
  std::vector<std::pair<std::uint64_t, std::size_t>> order(load.size());
  for (std::size_t t = 0; t < load.size(); ++t) {
    const Int3 at = grid.tile_coordinates(load.tile[t]);
    order[t] = {hilbert_position({on_curve(at[0]), on_curve(at[1]), on_curve(at[2])}, bits), t};
  }
  std::sort(order.begin(), order.end());

  std::vector<GlobalIndex> along_curve(load.size());
  for (std::size_t n = 0; n < order.size(); ++n) along_curve[n] = load.weight[order[n].second];
  std::vector<std::int32_t> part(load.size(), 0);
  if (load.size() == 0) return part;
  const Cuts cuts = cut_chain(along_curve, std::min(n_parts, static_cast<int>(load.size())));
  for (std::size_t p = 0; p + 1 < cuts.size(); ++p)
    for (int n = cuts[p]; n < cuts[p + 1]; ++n) part[order[static_cast<std::size_t>(n)].second] = static_cast<int>(p);
  return part;
}

}  // namespace bulkley
