#pragma once
// How many particles each tile holds: what partitions and pools are made from.

#include <cstdint>
#include <numeric>
#include <vector>

#include "grid/grid_geometry.hpp"

namespace bulkley {

/// The tiles that hold particles, ascending, and what they hold.
struct TileCensus {
  int n_materials = 1;
  std::vector<TileIndex> tile;
  std::vector<GlobalIndex> count;    ///< particles of each material, [t * n_materials + material]
  std::vector<std::uint64_t> cells;  ///< bit n: a particle has the n-th node of the tile (z fastest) as its base node

  std::size_t size() const { return tile.size(); }
  GlobalIndex n_particles(std::size_t t) const {
    const auto first = count.begin() + static_cast<std::ptrdiff_t>(t) * n_materials;
    return std::accumulate(first, first + n_materials, GlobalIndex{0});
  }
  GlobalIndex n_particles() const { return std::accumulate(count.begin(), count.end(), GlobalIndex{0}); }
};

}  // namespace bulkley
