#pragma once
// The film that a yield-stress fluid comes to rest as on a level floor (docs/theory.md, "Films").

namespace bulkley {

/// A heap of `volume` (m^3) on a floor of `length` x `width` (m) between walls; `height` = yield stress / (density x
/// gravity), m, in simple shear. Precondition: all > 0.
struct Film {
  double volume, height, length, width;

  double radius() const;       ///< of the heap where no wall is in its way, m (T31)
  double middle() const;       ///< its height in the middle, m
  double mean_height() const;  ///< volume over area covered, m: round, or as a strip from wall to wall, or the whole floor
};

}  // namespace bulkley
