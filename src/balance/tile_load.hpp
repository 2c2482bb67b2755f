#pragma once
// What the tiles cost: the weights that partitions are made from.

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "particle/census.hpp"

namespace bulkley {

/// What one step costs, ns. A run measures its own (CostMeter); until then, and for predictions, these are those of a
/// recent processor. Only their ratios decide how tiles are divided.
struct CostModel {
  std::vector<double> particle;  ///< by material; beyond its end `default_particle`
  double node = 5.0;             ///< of each node of a tile that holds particles
  double byte = 0.2;             ///< of each byte that a rank sends or receives
  double message = 2000.0;       ///< of each message that a rank sends or receives
  int n_exchanges = 1;           ///< of nodes in a step; a number, not a time
  static constexpr double default_particle = 80.0;

  double of_particle(int material) const {
    return material < static_cast<int>(particle.size()) ? particle[static_cast<std::size_t>(material)] : default_particle;
  }
};

/// The tiles that cost something, ascending, and what they cost.
struct TileLoad {
  std::vector<TileIndex> tile;
  std::vector<GlobalIndex> weight;   ///< > 0; ps
  std::vector<GlobalIndex> count;    ///< particles
  std::vector<std::uint64_t> cells;  ///< as TileCensus::cells

  std::size_t size() const { return tile.size(); }
  GlobalIndex total() const { return std::accumulate(weight.begin(), weight.end(), GlobalIndex{0}); }
};

/// Weights of the tiles of a census. Not collective.
TileLoad tile_load(const TileCensus& census, const CostModel& cost);

/// The tiles that hold particles, of numbers of particles by TileIndex; those are the weights, too. Not collective.
TileLoad tile_load(std::span<const GlobalIndex> n_particles);

}  // namespace bulkley
