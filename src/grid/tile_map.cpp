#include "grid/tile_map.hpp"

#include <algorithm>
#include <utility>

#include "bulkley/base/error.hpp"

namespace bulkley {

TileMap::TileMap(int n_ranks, std::vector<std::int32_t> owners) : n_ranks_(n_ranks), owners_(std::move(owners)) {
  BULKLEY_ASSERT(n_ranks >= 1);
  BULKLEY_ASSERT(
      std::all_of(owners_.begin(), owners_.end(), [&](std::int32_t rank) { return rank >= 0 && rank < n_ranks; }));
}

std::vector<TileIndex> TileMap::owned_tiles(std::int32_t rank) const {
  std::vector<TileIndex> tiles;
  for (TileIndex tile = 0; tile < n_tiles(); ++tile)
    if (owner(tile) == rank) tiles.push_back(tile);
  return tiles;
}

std::uint64_t TileMap::fingerprint() const {
  constexpr std::uint64_t prime = 1099511628211u;  // FNV-1a, a number at a time
  std::uint64_t hash = 14695981039346656037u;
  hash = (hash ^ static_cast<std::uint32_t>(n_ranks_)) * prime;
  for (const std::int32_t rank : owners_) hash = (hash ^ static_cast<std::uint32_t>(rank)) * prime;
  return (hash ^ owners_.size()) * prime;
}

std::vector<std::int32_t> TileMap::pack() && { return std::exchange(owners_, {}); }

TileMap TileMap::unpack(int n_ranks, std::vector<std::int32_t> packed) { return {n_ranks, std::move(packed)}; }

Int3 separable_tiles(const GridGeometry& grid) {
  Int3 n;
  for (int axis = 0; axis < 3; ++axis) {
    const int behind = grid.n_cells[axis] + grid.node_offset(axis) + 1;
    const bool apart = !grid.periodic[axis] && behind / tile_width != (behind - 2) / tile_width;
    n[axis] = grid.n_tiles(axis) - (apart ? 1 : 0);
  }
  return n;
}

}  // namespace bulkley
