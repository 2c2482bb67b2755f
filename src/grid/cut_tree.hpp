#pragma once
// Owners of tiles by a tree of cuts: recursive bisection, of space or of a Hilbert curve.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "grid/grid_geometry.hpp"
#include "grid/hilbert_curve.hpp"

namespace bulkley {

/// What cuts divide: space, across any axis; or the Hilbert curve, whose places (HilbertCurve::place) then stand for the
/// coordinates of tiles, and are cut across the first axis alone.
enum class Cutting { planes, curve };

/// Where a region of tiles is cut across an axis a: what lies below goes to the first half of the region's ranks. The cut
/// plane may be broken at a row and a tile (it is ragged), so that loads are even to within a tile: below is every tile
/// whose coordinates along (a, a + 1, a + 2) come before those of a threshold, in lexicographic order.
class Cut {
 public:
  Cut() = default;
  /// `threshold`: coordinates of a tile, x first, each from 0 to the number of tiles along its axis; or a place of the curve.
  Cut(int axis, const Int3& threshold) : bits_(static_cast<std::uint64_t>(axis) << 57 | key(axis, threshold)) {}
  static Cut of_bits(std::uint64_t bits) {
    Cut cut;
    cut.bits_ = bits;
    return cut;
  }
  std::uint64_t bits() const { return bits_; }

  int axis() const { return static_cast<int>(bits_ >> 57); }
  /// `at`: coordinates, or the place on the curve, of a tile.
  bool below(const Int3& at) const { return key(axis(), at) < threshold(); }

  bool operator==(const Cut&) const = default;

 private:
  friend class CutTree;
  static constexpr int coordinate_bits = HilbertCurve::digit_bits;
  std::uint64_t threshold() const { return bits_ & ((std::uint64_t{1} << 57) - 1); }
  static std::uint64_t key(int axis, const Int3& tile) {
    const auto at = [&](int n) { return static_cast<std::uint64_t>(tile[static_cast<std::size_t>((axis + n) % 3)]); };
    // A sum: the last coordinate of a threshold may be one more than there are.
    return (at(0) << 2 * coordinate_bits) + (at(1) << coordinate_bits) + at(2);
  }

  std::uint64_t bits_ = 0;
};

/// How a region of consecutive ranks is halved: between nodes of the machine as long as it has more than one, so that few bytes leave them,
/// and then in the middle. Regions of several nodes begin with a node.
struct RankHalves {
  int ranks_per_node = 1;  ///< >= 1; ranks 0 .. ranks_per_node - 1 share the first node, and so on; the last may have fewer

  /// Ranks of the lower half of a region of `n_ranks`, at least two.
  constexpr int n_below(int n_ranks) const {
    if (n_ranks <= ranks_per_node) return n_ranks / 2;
    return (n_ranks + ranks_per_node - 1) / ranks_per_node / 2 * ranks_per_node;
  }
  /// Number of the cut of the region of the ranks first .. first + n_ranks - 1, of at least two.
  constexpr std::size_t cut_of(int first, int n_ranks) const {
    return static_cast<std::size_t>(first + n_below(n_ranks) - 1);
  }

  bool operator==(const RankHalves&) const = default;
};

/// Divides all tiles of a grid, empty ones included, among ranks: a region of n ranks is cut, the lower half of them (RankHalves) shares
/// what lies below and the others the rest, until each has a region of its own. 8 bytes a rank. A tree that cuts the curve gives
/// each rank a run of it. Not collective.
class CutTree {
 public:
  CutTree() = default;
  /// One rank.
  explicit CutTree(const GridGeometry& grid) : CutTree(grid, {}) {}
  /// `cuts`: number r parts the regions of ranks r and r + 1.
  CutTree(const GridGeometry& grid, std::vector<Cut> cuts, Cutting cutting = Cutting::planes, RankHalves halves = {})
      : CutTree({grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)}, std::move(cuts), cutting, halves) {}
  CutTree(const Int3& n_tiles, std::vector<Cut> cuts, Cutting cutting = Cutting::planes, RankHalves halves = {})
      : n_tiles_(n_tiles), cutting_(cutting), halves_(halves), curve_(n_tiles), cuts_(std::move(cuts)) {}

  int n_ranks() const { return static_cast<int>(cuts_.size()) + 1; }
  const Int3& n_tiles() const { return n_tiles_; }
  const std::vector<Cut>& cuts() const { return cuts_; }
  Cutting cutting() const { return cutting_; }
  const RankHalves& halves() const { return halves_; }

  std::int32_t owner(TileIndex tile) const {
    return owner(Int3{tile / (n_tiles_[1] * n_tiles_[2]), tile / n_tiles_[2] % n_tiles_[1], tile % n_tiles_[2]});
  }
  std::int32_t owner(const Int3& tile) const {
    return owner_of_place(cutting_ == Cutting::curve ? curve_.place(tile) : tile);
  }
  /// Of the tile at this place of the curve, or at these coordinates: at what its cuts divide.
  std::int32_t owner_of_place(const Int3& at) const {
    const std::uint64_t key[3] = {Cut::key(0, at), Cut::key(1, at), Cut::key(2, at)};
    int first = 0;
    for (int n = n_ranks(); n > 1;) {
      const int below = halves_.n_below(n);
      const Cut cut = cuts_[static_cast<std::size_t>(first + below - 1)];
      if (key[cut.axis()] < cut.threshold()) {
        n = below;
      } else {
        first += below;
        n -= below;
      }
    }
    return first;
  }

  bool operator==(const CutTree&) const = default;

 private:
  Int3 n_tiles_{0, 0, 0};
  Cutting cutting_ = Cutting::planes;
  RankHalves halves_;
  HilbertCurve curve_;
  std::vector<Cut> cuts_;
};

}  // namespace bulkley
