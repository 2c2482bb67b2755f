#include "bulkley/domain/load.hpp"

#include <algorithm>
#include <bit>
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

}  // namespace bulkley
