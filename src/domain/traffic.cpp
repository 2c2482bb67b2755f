#include "bulkley/domain/traffic.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

#include "bulkley/kernel/cells.hpp"
#include "bulkley/kernel/pool.hpp"

namespace bulkley {

namespace {

// A tile of nodes in the numbering of pools, which does not wrap: along a periodic axis footprints end beyond the last tile.
using NodeTile = std::pair<Int3, int>;  // coordinates, rank whose pool reaches it

// The 64 nodes of a tile, of which tiles below along some axes reach the first ones.
class NodeMasks {
 public:
  explicit NodeMasks(int footprint) {
    for (int s = 0; s < 8; ++s)
      for (int n = 0; n < tile_nodes; ++n) {
        const int at[3] = {n / 16, n / 4 % 4, n % 4};
        bool reached = true;
        for (int axis = 0; axis < 3; ++axis) reached = reached && (!(s >> axis & 1) || at[axis] < footprint - tile_width);
        if (reached) reached_[s] |= std::uint64_t{1} << n;
      }
  }
  /// Nodes of tile t + s that the footprint of tile t holds; bit `axis` of s is the step along it.
  std::uint64_t reached(int s) const { return reached_[s]; }
  /// Nodes of the tile at these coordinates that the grid has.
  static std::uint64_t existing(const GridGeometry& grid, const Int3& tile) {
    std::uint64_t mask = 0;
    for (int n = 0; n < tile_nodes; ++n) {
      const int at[3] = {n / 16, n / 4 % 4, n % 4};
      bool exists = true;
      for (int axis = 0; axis < 3; ++axis)
        exists = exists && (grid.periodic[axis] || tile[axis] * tile_width + at[axis] < grid.n_nodes(axis));
      if (exists) mask |= std::uint64_t{1} << n;
    }
    return mask;
  }

 private:
  std::uint64_t reached_[8] = {};
};

// Nodes that the footprints of `tiles` reach, by {tile of nodes, rank}: sorted, each pair once.
std::vector<std::pair<NodeTile, std::uint64_t>> reached_nodes(const GridGeometry& grid, const Partition& partition,
                                                              const std::vector<TileIndex>& tiles) {
  const NodeMasks masks(footprint_width(grid.order));
  std::vector<std::pair<NodeTile, std::uint64_t>> all;
  all.reserve(8 * tiles.size());
  for (const TileIndex tile : tiles) {
    const Int3 at = grid.tile_coordinates(tile);
    for (int s = 0; s < 8; ++s) {
      const Int3 there{at[0] + (s & 1), at[1] + (s >> 1 & 1), at[2] + (s >> 2 & 1)};
      all.push_back({{there, partition.worker[static_cast<std::size_t>(tile)]}, masks.reached(s)});
    }
  }
  std::sort(all.begin(), all.end());
  std::size_t last = 0;
  for (std::size_t n = 1; n < all.size(); ++n) {
    if (all[n].first == all[last].first)
      all[last].second |= all[n].second;
    else
      all[++last] = all[n];
  }
  if (!all.empty()) all.resize(last + 1);
  return all;
}

// The tiles of the pools of all ranks; each has one worker, in whose pool it is.
std::vector<TileIndex> pool_tiles(const GridGeometry& grid, const Partition& partition, const TileLoad& load) {
  const auto& worker = partition.worker;
  std::vector<TileIndex> tiles;
  for (std::size_t t = 0; t < load.size(); ++t)
    visit_reach(grid, grid.tile_coordinates(load.tile[t]), load.cells[t], [&](TileIndex there) {
      if (worker[static_cast<std::size_t>(there)] == worker[static_cast<std::size_t>(load.tile[t])]) tiles.push_back(there);
    });
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

}  // namespace

std::vector<RankTraffic> predict_traffic(const GridGeometry& grid, const Partition& partition, const TileLoad& load) {
  std::vector<RankTraffic> traffic(static_cast<std::size_t>(partition.size()));
  const auto rank_at = [&](int rank) -> RankTraffic& { return traffic[static_cast<std::size_t>(rank)]; };
  for (std::size_t t = 0; t < load.size(); ++t) {
    RankTraffic& rank = rank_at(partition.worker[static_cast<std::size_t>(load.tile[t])]);
    rank.load += load.weight[t];
    rank.n_particles += load.count[t];
  }

  const std::vector<TileIndex> tiles = pool_tiles(grid, partition, load);
  for (const TileIndex tile : tiles) ++rank_at(partition.worker[static_cast<std::size_t>(tile)]).n_tiles;
  const std::vector<std::int32_t> owner = node_owners(grid, partition);
  std::vector<std::pair<std::int32_t, std::int32_t>> routes;  // {worker, owner}
  for (const auto& [where, nodes] : reached_nodes(grid, partition, tiles)) {
    const auto& [at, rank] = where;
    rank_at(rank).n_pool_nodes += std::popcount(nodes);
    Int3 wrapped = at;
    bool exists = true;
    for (int axis = 0; axis < 3; ++axis) {
      if (grid.periodic[axis]) wrapped[axis] %= grid.n_tiles(axis);
      exists = exists && wrapped[axis] < grid.n_tiles(axis);
    }
    if (!exists) continue;
    const std::int32_t to = owner[static_cast<std::size_t>(grid.tile_index(wrapped))];
    if (to == rank) continue;
    const GlobalIndex bytes = std::popcount(nodes & NodeMasks::existing(grid, wrapped)) * GlobalIndex{sizeof(Node)};
    if (bytes == 0) continue;
    rank_at(rank).bytes_add += bytes;
    rank_at(to).bytes_get += bytes;
    routes.emplace_back(rank, to);
  }
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

  for (const auto& [where, nodes] : reached_nodes(grid, partition, load.tile)) {
    RankTraffic& rank = rank_at(where.second);
    Int3 at = where.first;
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) inside = inside && at[axis] < grid.n_tiles(axis);
    const bool own = inside && std::binary_search(load.tile.begin(), load.tile.end(), grid.tile_index(at)) &&
                     partition.worker[static_cast<std::size_t>(grid.tile_index(at))] == where.second;
    (own ? rank.n_worked_nodes : rank.n_halo_nodes) += std::popcount(nodes);
  }
  return traffic;
}

double predicted_step(const std::vector<RankTraffic>& traffic, const CostModel& cost) {
  double slowest = 0.0;
  for (const RankTraffic& rank : traffic) {
    // What a rank sends in one half of the exchange it receives in the other.
    const double bytes = 2.0 * static_cast<double>(rank.bytes_add + rank.bytes_get);
    const double messages = 2.0 * (rank.messages_add + rank.messages_get);
    slowest = std::max(slowest, 1e-3 * static_cast<double>(rank.load) + cost.byte * bytes + cost.message * messages);
  }
  return 1e-9 * slowest;
}

}  // namespace bulkley
