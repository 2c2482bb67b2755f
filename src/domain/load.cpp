#include "bulkley/domain/load.hpp"

#include <algorithm>
#include <cmath>

#include "bulkley/base/gather.hpp"

namespace bulkley {

TileLoad tile_load(const TileCensus& census, const CostModel& cost) {
  constexpr double picoseconds = 1000.0;
  TileLoad load;
  load.tile = census.tile;
  load.cells = census.cells;
  load.weight.reserve(census.size());
  for (std::size_t t = 0; t < census.size(); ++t) {
    double nanoseconds = cost.node * tile_nodes;
    for (int m = 0; m < census.n_materials; ++m)
      nanoseconds +=
          cost.of_particle(m) * static_cast<double>(census.count[t * static_cast<std::size_t>(census.n_materials) + m]);
    load.weight.push_back(std::max<GlobalIndex>(1, std::llround(picoseconds * nanoseconds)));
    load.count.push_back(census.n_particles(t));
  }
  return load;
}

TileLoad tile_load(std::span<const GlobalIndex> n_particles) {
  TileLoad load;
  for (std::size_t tile = 0; tile < n_particles.size(); ++tile) {
    if (n_particles[tile] <= 0) continue;
    load.tile.push_back(static_cast<TileIndex>(tile));
    load.weight.push_back(n_particles[tile]);
    load.count.push_back(n_particles[tile]);
    load.cells.push_back(~std::uint64_t{0});
  }
  return load;
}

TileCensus gather_census(const Comm& comm, const TileCensus& local) {
  const TileCensus all{local.n_materials, gather_values(comm, local.tile), gather_values(comm, local.count),
                       gather_values(comm, local.cells)};
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return all.tile[a] < all.tile[b]; });
  const auto n_materials = static_cast<std::size_t>(local.n_materials);
  TileCensus merged;
  merged.n_materials = local.n_materials;
  for (const std::size_t t : order) {
    if (merged.tile.empty() || merged.tile.back() != all.tile[t]) {
      merged.tile.push_back(all.tile[t]);
      merged.cells.push_back(0);
      merged.count.resize(merged.count.size() + n_materials, 0);
    }
    merged.cells.back() |= all.cells[t];
    for (std::size_t m = 0; m < n_materials; ++m)
      merged.count[merged.count.size() - n_materials + m] += all.count[t * n_materials + m];
  }
  return merged;
}

}  // namespace bulkley
