#pragma once
// Cuts of a grid of tiles into boxes of about equal load.

#include "balance/partition.hpp"
#include "balance/region_sums.hpp"

namespace bulkley {

using Cuts = std::vector<int>;  ///< first layer of each part, and one past the last layer

/// Boxes as make_partition describes them, the same for every participant; none where box_fault. `load`: this participant's part; each
/// tile is in one. Takes about ten sums for each way to write n_ranks as three factors, of as many numbers as there are tiles along an
/// axis times ranks across it; none if `uniform`. Collective among the participants.
std::optional<Boxes> cut_boxes(const GridGeometry& grid, bool uniform, const TileLoad& load, int n_ranks, RegionSums& sums);

/// Largest over mean load of boxes, where empty space counts a little too. Not collective.
double box_imbalance(const GridGeometry& grid, const Boxes& boxes, const TileLoad& load);

}  // namespace bulkley
