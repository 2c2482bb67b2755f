#pragma once
// When a new map of tiles is worth its price: pure functions of loads and measured costs.

#include <optional>

#include "balance/partition.hpp"

namespace bulkley {

/// What a change of maps costs, s; measured as a run continues.
struct ChangeCost {
  double rebuild = 1e-3;   ///< of pools and exchange
  double particle = 1e-6;  ///< of each particle that the busiest rank sends or receives
  double tile = 1e-5;      ///< of making a whole new map, for each loaded tile
};

/// What worthwhile_change has found.
struct Change {
  std::optional<Partition> partition;  ///< none: the present one stays
  bool whole = false;                  ///< a whole new map, not one with few tiles moved
  double making = 0.0;                 ///< s of wall time that a whole new map took, whether it is taken or not
};

/// The partition that saves more than it costs, if there is one: over the next `horizon` steps, the predicted time of the
/// slowest rank under `present` less that under the new map must exceed the cost of the change, and be at least 2 % of the
/// former (so that noise in the measured costs moves nothing). Candidates are `present` with few tiles moved (rebalanced) or
/// few of its cuts (recut), and, where that leaves enough to be gained, a whole new map by `automatic`. `fresh_exchange`: predicted_exchange when the
/// last whole map was new, s; what another may come down to. `ranks_per_node` as in
/// PartitionSettings. Not collective.
Change worthwhile_change(const GridGeometry& grid, const TileLoad& load, const Partition& present, const CostModel& cost,
                         const ChangeCost& change, double horizon, double fresh_exchange, int ranks_per_node = 0);

}  // namespace bulkley
