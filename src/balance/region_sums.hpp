#pragma once
// Sums over those who share the tiles of a region: one process, or ranks.

#include <cstddef>
#include <span>

#include "bulkley/base/types.hpp"

namespace bulkley {

/// Numbers of a region, of which every participant has a part.
class RegionSums {
 public:
  virtual ~RegionSums() = default;
  /// values[0 .. n_added): sums over the participants; those after them: the smallest. The same everywhere. Collective among
  /// the participants.
  virtual void combine(std::span<GlobalIndex> values, std::size_t n_added) = 0;
};

/// Of one participant, which has all.
class WholeRegion final : public RegionSums {
 public:
  void combine(std::span<GlobalIndex>, std::size_t) override {}
};

}  // namespace bulkley
