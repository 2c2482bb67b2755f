#include "rebalance/share.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

#include "parallel/gather.hpp"

namespace bulkley {

TileCensus gather_census(const Comm& comm, const TileCensus& local) {
  const auto n_materials = static_cast<std::size_t>(local.n_materials);
  std::vector<std::int64_t> packed;  // tile, cells, counts; one message a rank
  packed.reserve(local.size() * (2 + n_materials));
  for (std::size_t t = 0; t < local.size(); ++t) {
    packed.push_back(local.tile[t]);
    packed.push_back(std::bit_cast<std::int64_t>(local.cells[t]));
    for (std::size_t m = 0; m < n_materials; ++m) packed.push_back(local.count[t * n_materials + m]);
  }
  packed = gather_values(comm, packed);
  const auto row = [&](std::size_t t) { return packed.data() + t * (2 + n_materials); };

  std::vector<std::size_t> order(packed.size() / (2 + n_materials));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return row(a)[0] < row(b)[0]; });
  TileCensus merged;
  merged.n_materials = local.n_materials;
  for (const std::size_t t : order) {
    const auto tile = static_cast<TileIndex>(row(t)[0]);
    if (merged.tile.empty() || merged.tile.back() != tile) {
      merged.tile.push_back(tile);
      merged.cells.push_back(0);
      merged.count.resize(merged.count.size() + n_materials, 0);
    }
    merged.cells.back() |= std::bit_cast<std::uint64_t>(row(t)[1]);
    for (std::size_t m = 0; m < n_materials; ++m) merged.count[merged.count.size() - n_materials + m] += row(t)[2 + m];
  }
  return merged;
}

Partition share_partition(const Comm& comm, Partition partition) {
  // Size of the packed map, whether there are boxes, their process grid, imbalance as bits and nodes; never more than so
  // many numbers, for a process has a rank or more.
  std::vector<std::int64_t> head(6 + static_cast<std::size_t>(comm.size()) + 2, 0);
  std::vector<std::int32_t> packed;
  if (comm.is_root()) {
    BULKLEY_ASSERT(partition.map.n_ranks() == comm.size());
    packed = std::move(partition.map).pack();
    std::size_t n = 0;
    head[n++] = static_cast<std::int64_t>(packed.size());
    head[n++] = partition.boxes ? 1 : 0;
    const Boxes boxes = partition.boxes.value_or(Boxes{});
    for (const int ranks : boxes.n_ranks) head[n++] = ranks;
    head[n++] = std::bit_cast<std::int64_t>(boxes.imbalance);
    for (const std::vector<int>& nodes : boxes.nodes)
      for (const int count : nodes) head[n++] = count;
  }
  broadcast_values(comm, head);
  std::size_t n = 0;
  packed.resize(static_cast<std::size_t>(head[n++]));
  partition.boxes.reset();
  if (head[n++] != 0) {
    Boxes& boxes = partition.boxes.emplace();
    for (int& ranks : boxes.n_ranks) ranks = static_cast<int>(head[n++]);
    boxes.imbalance = std::bit_cast<double>(head[n++]);
    for (int axis = 0; axis < 3; ++axis) {
      boxes.nodes[axis].resize(static_cast<std::size_t>(boxes.n_ranks[axis]));
      for (int& count : boxes.nodes[axis]) count = static_cast<int>(head[n++]);
    }
  }
  broadcast_values(comm, packed);
  partition.map = TileMap::unpack(comm.size(), std::move(packed));
  return partition;
}

}  // namespace bulkley
