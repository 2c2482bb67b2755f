#pragma once
// From tiles to their places in a list of them.

#include <bit>
#include <cstdint>
#include <vector>

#include "grid/grid_geometry.hpp"

namespace bulkley {

/// The place of each tile in a list. Takes at most 32 bytes a tile, wherever the tiles lie: where a table from the first to the
/// last of them takes more (a part in two pieces may span the grid), it is a hash table with linear probing, at most half
/// full. The multiplier is 2^32 over the golden ratio, which spreads tiles that follow each other (Knuth, The Art of Computer
/// Programming 3, section 6.4). Not collective.
class SlotTable {
 public:
  SlotTable() = default;
  /// `tiles`: ascending, each once.
  explicit SlotTable(const std::vector<TileIndex>& tiles) {
    if (tiles.empty()) return;
    first_tile_ = tiles.front();
    const auto span = static_cast<std::size_t>(tiles.back() - first_tile_) + 1;
    if (span <= 8 * tiles.size()) {
      by_tile_.assign(span, -1);
      for (std::size_t t = 0; t < tiles.size(); ++t)
        by_tile_[static_cast<std::size_t>(tiles[t] - first_tile_)] = static_cast<LocalIndex>(t);
      return;
    }
    const int bits = static_cast<int>(std::bit_width(2 * tiles.size() - 1));
    shift_ = 32 - bits;
    entries_.resize(std::size_t{1} << bits);
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      std::size_t n = first(tiles[t]);
      while (entries_[n].slot >= 0) n = next(n);
      entries_[n] = {tiles[t], static_cast<LocalIndex>(t)};
    }
  }

  /// -1 for a tile that is not in the list.
  LocalIndex slot(TileIndex tile) const {
    if (entries_.empty()) {
      const TileIndex relative = tile - first_tile_;
      return relative >= 0 && relative < static_cast<TileIndex>(by_tile_.size())
                 ? by_tile_[static_cast<std::size_t>(relative)]
                 : -1;
    }
    std::size_t n = first(tile);
    while (entries_[n].slot >= 0 && entries_[n].tile != tile) n = next(n);
    return entries_[n].slot;
  }

  std::size_t memory() const { return by_tile_.capacity() * sizeof(LocalIndex) + entries_.capacity() * sizeof(Entry); }

 private:
  struct Entry {
    TileIndex tile = -1;
    LocalIndex slot = -1;
  };
  std::size_t first(TileIndex tile) const { return (static_cast<std::uint32_t>(tile) * 2654435769u) >> shift_; }
  std::size_t next(std::size_t n) const { return (n + 1) & (entries_.size() - 1); }

  std::vector<LocalIndex> by_tile_;  ///< from the first tile on; empty where the tiles are too far apart
  TileIndex first_tile_ = 0;
  std::vector<Entry> entries_;  ///< as many as a power of two
  int shift_ = 31;
};

}  // namespace bulkley
