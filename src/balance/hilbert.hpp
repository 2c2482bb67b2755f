#pragma once
// A Hilbert curve through the tiles.

#include "balance/tile_load.hpp"

namespace bulkley {

/// Position along the Hilbert curve of order `bits` of the cube cell `at` (0 <= at < 2^bits along each axis, bits <= 20):
/// cells that follow each other share a face. After Skilling (2004), "Programming the Hilbert curve".
std::uint64_t hilbert_position(const Int3& at, int bits);

/// Part of each loaded tile: chunks of the curve with the smallest possible largest load. With fewer tiles than parts, the
/// last parts are empty.
std::vector<std::int32_t> hilbert_parts(const GridGeometry& grid, const TileLoad& load, int n_parts);

}  // namespace bulkley
