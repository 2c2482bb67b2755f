#include "balance/tile_load.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace bulkley
