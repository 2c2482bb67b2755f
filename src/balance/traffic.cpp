#include "balance/traffic.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "grid/node_pool.hpp"
#include "grid/slot_table.hpp"
#include "kernel/cells.hpp"

namespace bulkley {

namespace {

// Nodes of a tile, one bit each.
using NodeMask = std::uint64_t;

// Which nodes of tile t + s the footprint of tile t holds; bit `axis` of s is the step along it.
std::array<NodeMask, 8> reached_masks(const GridGeometry& grid) {
  const int reach = footprint_width(grid.order) - tile_width;
  std::array<NodeMask, 8> masks{};
  for (int s = 0; s < 8; ++s)
    for (int n = 0; n < tile_nodes; ++n) {
      const int at[3] = {n / 16, n / 4 % 4, n % 4};
      bool reached = true;
      for (int axis = 0; axis < 3; ++axis) reached = reached && (!(s >> axis & 1) || at[axis] < reach);
      if (reached) masks[static_cast<std::size_t>(s)] |= NodeMask{1} << n;
    }
  return masks;
}

// Nodes of the tile at these coordinates that the grid has; along the axis of a plane flow as often as footprints have them.
NodeMask existing_nodes(const GridGeometry& grid, const Int3& tile) {
  const auto n_nodes = [&](int axis) { return grid.is_plane(axis) ? stencil_width(grid.order) : grid.n_nodes(axis); };
  bool whole = true;
  for (int axis = 0; axis < 3; ++axis) whole = whole && (tile[axis] + 1) * tile_width <= n_nodes(axis);
  if (whole) return ~NodeMask{0};
  NodeMask mask = 0;
  for (int n = 0; n < tile_nodes; ++n) {
    const int at[3] = {n / 16, n / 4 % 4, n % 4};
    bool exists = true;
    for (int axis = 0; axis < 3; ++axis) exists = exists && tile[axis] * tile_width + at[axis] < n_nodes(axis);
    if (exists) mask |= NodeMask{1} << n;
  }
  return mask;
}

Int3 step_of(int s) { return {s & 1, s >> 1 & 1, s >> 2 & 1}; }

// Calls visit(coordinates, rank, nodes) for every tile of nodes that footprints of `tiles` (ascending) reach and every rank
// among their owners. Coordinates are as pools number nodes: they do not wrap, so that along a periodic axis footprints end
// beyond the last tile.
template <class Visit>
void visit_reached(const GridGeometry& grid, const TileMap& map, const std::vector<TileIndex>& tiles, Visit visit) {
  const std::array<NodeMask, 8> masks = reached_masks(grid);
  const Int3 n{grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)};
  const SlotTable given(tiles);
  for (const TileIndex tile : tiles) {
    const Int3 from = grid.tile_coordinates(tile);
    for (int s = 0; s < 8; ++s) {
      const Int3 step = step_of(s);
      const Int3 at{from[0] + step[0], from[1] + step[1], from[2] + step[2]};
      std::int32_t ranks[8];
      NodeMask nodes[8];
      int n_found = 0;
      for (int back = 0; back < 8; ++back) {
        const Int3 d = step_of(back);
        const Int3 source{at[0] - d[0], at[1] - d[1], at[2] - d[2]};
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) inside = inside && source[axis] >= 0 && source[axis] < n[axis];
        if (!inside || given.slot(grid.tile_index(source)) < 0) continue;
        if (back < s) break;  // of the tiles that reach it, the one with the smallest step visits
        const std::int32_t rank = map.owner(grid.tile_index(source));
        int k = 0;
        while (k < n_found && ranks[k] != rank) ++k;
        if (k == n_found) ranks[n_found] = rank, nodes[n_found++] = 0;
        nodes[k] |= masks[static_cast<std::size_t>(back)];
      }
      for (int k = 0; k < n_found; ++k) visit(at, ranks[k], nodes[k]);
    }
  }
}

// The tiles of the pools of all ranks; each is in its owner's pool.
std::vector<TileIndex> pool_tiles(const GridGeometry& grid, const TileMap& map, const TileLoad& load) {
  std::vector<TileIndex> tiles;
  for (std::size_t t = 0; t < load.size(); ++t)
    visit_reach(grid, grid.tile_coordinates(load.tile[t]), load.cells[t], [&](TileIndex there) {
      if (map.owner(there) == map.owner(load.tile[t])) tiles.push_back(there);
    });
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

}  // namespace

std::vector<RankTraffic> predict_traffic(const GridGeometry& grid, const TileMap& map, const TileLoad& load,
                                         int ranks_per_node) {
  std::vector<RankTraffic> traffic(static_cast<std::size_t>(map.n_ranks()));
  const auto rank_at = [&](int rank) -> RankTraffic& { return traffic[static_cast<std::size_t>(rank)]; };
  for (std::size_t t = 0; t < load.size(); ++t) {
    RankTraffic& rank = rank_at(map.owner(load.tile[t]));
    rank.load += load.weight[t];
    rank.n_particles += load.count[t];
    rank.n_cells += std::popcount(load.cells[t]);
  }

  const std::vector<TileIndex> tiles = pool_tiles(grid, map, load);
  for (const TileIndex tile : tiles) ++rank_at(map.owner(tile)).n_tiles;
  const NodeOwner owner(grid, map);
  std::vector<std::pair<std::int32_t, std::int32_t>> routes;  // {sender, owner of nodes}
  visit_reached(grid, map, tiles, [&](const Int3& at, std::int32_t rank, NodeMask nodes) {
    rank_at(rank).n_pool_nodes += std::popcount(nodes);
    Int3 wrapped = at;
    for (int axis = 0; axis < 3; ++axis) {
      if (grid.periodic[axis] && !grid.is_plane(axis)) wrapped[axis] %= grid.n_tiles(axis);
      if (wrapped[axis] == grid.n_tiles(axis)) return;  // beyond the grid
    }
    const std::int32_t to = owner(wrapped);
    const GlobalIndex bytes = std::popcount(nodes & existing_nodes(grid, wrapped)) * GlobalIndex{sizeof(Node)};
    if (to == rank || bytes == 0) return;
    rank_at(rank).bytes_add += bytes;
    rank_at(to).bytes_get += bytes;
    if (ranks_per_node > 0 && rank / ranks_per_node != to / ranks_per_node) {
      rank_at(rank).bytes_off_node += bytes;
      rank_at(to).bytes_off_node += bytes;
    }
    routes.emplace_back(rank, to);
  });
  std::sort(routes.begin(), routes.end());
  routes.erase(std::unique(routes.begin(), routes.end()), routes.end());
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (const auto& [rank, to] : routes) {
    ++rank_at(rank).messages_add;
    ++rank_at(to).messages_get;
    pairs.emplace_back(rank, to);
    pairs.emplace_back(to, rank);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  for (const auto& pair : pairs) ++rank_at(pair.first).n_neighbours;

  visit_reached(grid, map, load.tile, [&](const Int3& at, std::int32_t rank, NodeMask nodes) {
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) inside = inside && at[axis] < grid.n_tiles(axis);
    const bool own = inside && std::binary_search(load.tile.begin(), load.tile.end(), grid.tile_index(at)) &&
                     map.owner(grid.tile_index(at)) == rank;
    (own ? rank_at(rank).n_worked_nodes : rank_at(rank).n_halo_nodes) += std::popcount(nodes);
  });
  return traffic;
}

namespace {

// What a rank sends in one half of an exchange it receives in the other.
double exchange_nanoseconds(const RankTraffic& rank, const CostModel& cost) {
  return 2.0 * cost.n_exchanges *
         (cost.byte * static_cast<double>(rank.bytes_add + rank.bytes_get) +
          cost.message * (rank.messages_add + rank.messages_get));
}

}  // namespace

double predicted_exchange(const std::vector<RankTraffic>& traffic, const CostModel& cost) {
  double slowest = 0.0;
  for (const RankTraffic& rank : traffic) slowest = std::max(slowest, exchange_nanoseconds(rank, cost));
  return 1e-9 * slowest;
}

double predicted_step(const std::vector<RankTraffic>& traffic, const CostModel& cost) {
  double slowest = 0.0;
  for (const RankTraffic& rank : traffic)
    slowest = std::max(slowest, 1e-3 * static_cast<double>(rank.load) + exchange_nanoseconds(rank, cost));
  return 1e-9 * slowest;
}

}  // namespace bulkley
