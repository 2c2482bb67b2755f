#pragma once
// What a map of tiles makes ranks do in every step, computed from tiles alone.

#include <vector>

#include "balance/partition.hpp"

namespace bulkley {

/// One rank in one step. An exchange adds pools into owners and brings velocities back; schemes with a FLIP part make two.
struct RankTraffic {
  GlobalIndex load = 0;         ///< of its tiles, ps
  GlobalIndex n_particles = 0;  ///< in its tiles
  GlobalIndex n_cells = 0;      ///< base cells with particles
  GlobalIndex n_tiles = 0;      ///< of its pool: those with particles and those its particles may enter
  GlobalIndex n_pool_nodes = 0;
  GlobalIndex n_halo_nodes = 0;    ///< of the footprints of its tiles with particles, beyond those tiles
  GlobalIndex n_worked_nodes = 0;  ///< of its tiles with particles
  GlobalIndex bytes_add = 0;       ///< it sends to owners
  GlobalIndex bytes_get = 0;       ///< it sends back, as an owner
  int messages_add = 0, messages_get = 0;
  int n_neighbours = 0;  ///< other ranks that it sends to or receives from
  GlobalIndex bytes_off_node = 0;  ///< of bytes_add and bytes_get, those to ranks of other nodes
};

/// Exact for particles as the load has them: the pools, bytes and messages are those that Exchange would make. Not
/// collective.
/// `ranks_per_node`: that many ranks that follow each other share a node; 0: all ranks do.
std::vector<RankTraffic> predict_traffic(const GridGeometry& grid, const TileMap& map, const TileLoad& load,
                                         int ranks_per_node = 0);

/// Seconds of a step that the bytes and messages of the busiest rank take, in all its exchanges. Not collective.
double predicted_exchange(const std::vector<RankTraffic>& traffic, const CostModel& cost);

/// Seconds that the slowest rank needs for a step: its load, its bytes and its messages. Not collective.
double predicted_step(const std::vector<RankTraffic>& traffic, const CostModel& cost);

}  // namespace bulkley
