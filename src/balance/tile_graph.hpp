#pragma once
// The loaded tiles and which of them share nodes, as a graph.

#include "balance/tile_load.hpp"

namespace bulkley {

/// Adjacency in compressed rows: the neighbours of tile number t of the load are neighbour[first[t] .. first[t + 1]).
struct TileGraph {
  std::vector<GlobalIndex> first;       ///< there are up to 26 neighbours a tile: beyond 32 bits from 8e7 tiles on
  std::vector<std::int32_t> neighbour;  ///< numbers in the load
  /// What a border between the two tiles costs, in nodes that are sent, per entry of `neighbour`: 32 for a face, 8 for an
  /// edge, 2 for a corner with quadratic splines. Counting all common nodes of each pair (32, 16, 8) would count each node
  /// at a plane border four times.
  std::vector<std::int32_t> shared;

  std::int32_t size() const { return static_cast<std::int32_t>(first.size()) - 1; }
};

/// The graph of the tiles of a load; tiles touch by faces, edges and corners, also around periodic axes.
TileGraph tile_graph(const GridGeometry& grid, const TileLoad& load);

/// Connected pieces of the tiles of each part, summed over the parts.
int n_pieces(const TileGraph& graph, const std::vector<std::int32_t>& part);

}  // namespace bulkley
