#pragma once
// Cuts of a chain or a grid of tiles into runs or boxes of about equal load.

#include "balance/partition.hpp"

namespace bulkley {

using Cuts = std::vector<int>;  ///< first layer of each part, and one past the last layer

/// Cuts a chain of loads into `n_parts` runs of at least one, so that the largest is as small as it can be (to 1e-4 of the
/// mean), and near equal ones where that is free. Precondition: 1 <= n_parts <= loads.size().
Cuts cut_chain(const std::vector<GlobalIndex>& loads, int n_parts);

/// Boxes as make_partition describes them; none where box_fault.
std::optional<Boxes> cut_boxes(const GridGeometry& grid, bool uniform, const TileLoad& load, int n_ranks);

/// Largest over mean load of boxes, where empty space counts a little too.
double box_imbalance(const GridGeometry& grid, const Boxes& boxes, const TileLoad& load);

}  // namespace bulkley
