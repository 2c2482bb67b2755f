#pragma once
// What ranks know of tiles, put together without a root.

#include <functional>

#include "grid/tile_map.hpp"
#include "particle/census.hpp"
#include "rebalance/rank_range.hpp"

namespace bulkley {

/// The rank at which what ranks know of a tile is put together; the same on every rank.
using TileHome = std::function<int(TileIndex)>;

/// The census of the tiles whose home is this rank, ascending, each once: its own part and those of others merged. `local` may list tiles
/// in any order and more than once. Takes log2 P messages. Precondition: the same n_materials on every rank. Collective.
TileCensus merged_census(const Comm& comm, const TileCensus& local, const TileHome& home_of, SentMessages& sent);

/// Tiles are at home with those who own them under `present`, or else with ranks that a hash names. `present` must outlive it.
TileHome owners_or_hash(const TileMap* present, int n_ranks);

}  // namespace bulkley
