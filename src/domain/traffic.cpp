#include "bulkley/domain/traffic.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "bulkley/kernel/cells.hpp"
#include "bulkley/kernel/pool.hpp"

namespace bulkley {

namespace {

// A tile of nodes in the numbering of pools, which does not wrap: footprints reach one tile beyond the last.
struct NodeTile {
  Int3 at;
  int rank;             // whose pool reaches it
  std::uint64_t nodes;  // that the pool reaches
};

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
    bool whole = true;
    for (int axis = 0; axis < 3; ++axis)
      whole = whole && (grid.periodic[axis] || (tile[axis] + 1) * tile_width <= grid.n_nodes(axis));
    if (whole) return ~std::uint64_t{0};
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

// Calls visit(NodeTile) for the tiles of nodes that the footprints of `tiles` reach, once for each rank.
template <class Visit>
void visit_reached(const GridGeometry& grid, const Partition& partition, const std::vector<TileIndex>& tiles, Visit visit) {
  const NodeMasks masks(footprint_width(grid.order));
  const auto n_ranks = static_cast<std::uint64_t>(partition.size());
  const auto ny = static_cast<std::uint64_t>(grid.n_tiles(1)) + 1, nz = static_cast<std::uint64_t>(grid.n_tiles(2)) + 1;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> reached;  // {number of the tile and rank, nodes}: sorts fast
  reached.reserve(8 * tiles.size());
  for (const TileIndex tile : tiles) {
    const Int3 at = grid.tile_coordinates(tile);
    const auto rank = static_cast<std::uint64_t>(partition.worker[static_cast<std::size_t>(tile)]);
    for (int s = 0; s < 8; ++s) {
      const auto x = static_cast<std::uint64_t>(at[0] + (s & 1)), y = static_cast<std::uint64_t>(at[1] + (s >> 1 & 1)),
                 z = static_cast<std::uint64_t>(at[2] + (s >> 2 & 1));
      reached.emplace_back(((x * ny + y) * nz + z) * n_ranks + rank, masks.reached(s));
    }
  }
  std::sort(reached.begin(), reached.end());
  for (std::size_t n = 0; n < reached.size();) {
    const std::uint64_t key = reached[n].first, number = key / n_ranks;
    NodeTile there{{static_cast<int>(number / nz / ny), static_cast<int>(number / nz % ny), static_cast<int>(number % nz)},
                   static_cast<int>(key % n_ranks),
                   0};
    for (; n < reached.size() && reached[n].first == key; ++n) there.nodes |= reached[n].second;
    visit(there);
  }
}

// The tiles of the pools of all ranks; each has one worker, in whose pool it is.
std::vector<TileIndex> pool_tiles(const GridGeometry& grid, const Partition& partition, const TileLoad& load) {
  const auto& worker = partition.worker;
  std::vector<bool> in_pool(static_cast<std::size_t>(grid.n_tiles()), false);
  for (std::size_t t = 0; t < load.size(); ++t) {
    const std::int32_t rank = worker[static_cast<std::size_t>(load.tile[t])];
    visit_reach(grid, grid.tile_coordinates(load.tile[t]), load.cells[t], [&](TileIndex there) {
      if (worker[static_cast<std::size_t>(there)] == rank) in_pool[static_cast<std::size_t>(there)] = true;
    });
  }
  std::vector<TileIndex> tiles;
  for (std::size_t tile = 0; tile < in_pool.size(); ++tile)
    if (in_pool[tile]) tiles.push_back(static_cast<TileIndex>(tile));
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
  visit_reached(grid, partition, tiles, [&](const NodeTile& there) {
    const auto& [at, rank, nodes] = there;
    rank_at(rank).n_pool_nodes += std::popcount(nodes);
    Int3 wrapped = at;
    bool exists = true;
    for (int axis = 0; axis < 3; ++axis) {
      if (grid.periodic[axis]) wrapped[axis] %= grid.n_tiles(axis);
      exists = exists && wrapped[axis] < grid.n_tiles(axis);
    }
    if (!exists) return;
    const std::int32_t to = owner[static_cast<std::size_t>(grid.tile_index(wrapped))];
    if (to == rank) return;
    const GlobalIndex bytes = std::popcount(nodes & NodeMasks::existing(grid, wrapped)) * GlobalIndex{sizeof(Node)};
    if (bytes == 0) return;
    rank_at(rank).bytes_add += bytes;
    rank_at(to).bytes_get += bytes;
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

  std::vector<bool> loaded(static_cast<std::size_t>(grid.n_tiles()), false);
  for (const TileIndex tile : load.tile) loaded[static_cast<std::size_t>(tile)] = true;
  visit_reached(grid, partition, load.tile, [&](const NodeTile& there) {
    const auto& [at, number, nodes] = there;
    RankTraffic& rank = rank_at(number);
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) inside = inside && at[axis] < grid.n_tiles(axis);
    const auto tile = static_cast<std::size_t>(inside ? grid.tile_index(at) : 0);
    const bool own = inside && loaded[tile] && partition.worker[tile] == number;
    (own ? rank.n_worked_nodes : rank.n_halo_nodes) += std::popcount(nodes);
  });
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
