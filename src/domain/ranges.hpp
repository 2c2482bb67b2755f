#pragma once
// Cuts of a chain or a grid of tiles into runs or boxes of about equal load.

#include "bulkley/domain/partition.hpp"

namespace bulkley {

using Cuts = std::vector<int>;  ///< first layer of each part, and one past the last layer

/// Cuts a chain of loads into `n_parts` runs of at least one, so that the largest is as small as it can be (to 1e-4 of the mean),
/// and near equal ones where that is free. Precondition: 1 <= n_parts <= loads.size().
Cuts cut_chain(const std::vector<GlobalIndex>& loads, int n_parts);

/// The partition whose workers are the owners, as make_partition describes. Throws UsageError.
Partition cut_ranges(const GridGeometry& grid, bool uniform, const TileLoad& load, int n_ranks);

/// Largest over mean load of the boxes of nodes of a partition, where empty space counts a little too.
double owner_imbalance(const GridGeometry& grid, const Partition& partition, const TileLoad& load);

}  // namespace bulkley
