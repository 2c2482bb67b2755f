#pragma once
// Which rank owns which tile, and which rank owns the nodes of a tile.

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "grid/cut_tree.hpp"

namespace bulkley {

/// Owners by boxes of tiles: tile (x, y, z) belongs to rank of[0][x] + of[1][y] + of[2][z]. 4 bytes for each layer of tiles along each axis.
struct BoxOwners {
  int n_ranks = 1;  ///< every sum is below it
  std::array<std::vector<std::int32_t>, 3> of;
  bool operator==(const BoxOwners& other) const = default;
};

/// The owner of every tile of a grid: the rank that holds the tile's particles. A value, the same on every rank; ranks may
/// own nothing. What it stores is its own affair, boxes, a tree of cuts, of space or of a curve (8 bytes a rank), or a rank for each tile (4 bytes a
/// tile), so the rest of the program asks for owners and never holds a table of them. No function is collective.
class TileMap {
 public:
  /// No tiles, one rank.
  TileMap() = default;
  /// `owners`: rank by TileIndex, each in [0, n_ranks).
  TileMap(int n_ranks, std::vector<std::int32_t> owners);
  explicit TileMap(CutTree tree);
  explicit TileMap(BoxOwners boxes);

  int n_ranks() const { return n_ranks_; }
  TileIndex n_tiles() const;
  /// Precondition: 0 <= tile < n_tiles().
  std::int32_t owner(TileIndex tile) const {
    if (const auto* owners = std::get_if<Owners>(&stored_)) return (*owners)[static_cast<std::size_t>(tile)];
    if (const auto* tree = std::get_if<CutTree>(&stored_)) return tree->owner(tile);
    const auto& [x, y, z] = std::get<BoxOwners>(stored_).of;
    const auto t = static_cast<std::size_t>(tile), column = t / z.size();
    return x[column / y.size()] + y[column % y.size()] + z[t % z.size()];
  }
  /// The cuts that the map is made of; none where it has a table. Valid as long as the map is.
  const CutTree* tree() const { return std::get_if<CutTree>(&stored_); }

  /// Whether every tile has the same owner, out of as many ranks. Visits all tiles, unless what is stored is the same.
  bool operator==(const TileMap& other) const;
  /// A hash of what is stored: ranks compare it to see that they agree.
  std::uint64_t fingerprint() const;

  /// The map as numbers, to send it to other ranks. Moves them out of the map.
  std::vector<std::int32_t> pack() &&;
  /// The map among n_ranks that such numbers came from.
  static TileMap unpack(int n_ranks, std::vector<std::int32_t> packed);

  /// Bytes on this rank.
  std::size_t memory() const;

 private:
  using Owners = std::vector<std::int32_t>;  ///< by TileIndex
  int n_ranks_ = 1;
  std::variant<Owners, CutTree, BoxOwners> stored_;
};

/// Tiles along each axis that may go to different ranks. A node just behind a wall and its image just in front of it have
/// one owner: where they lie in different tiles, which can only be at the upper face, the last layer goes with the one
/// before. No particle belongs to it then. Not collective.
Int3 separable_tiles(const GridGeometry& grid);

/// The rank that sums up the nodes of a tile and updates them: the owner of the tile, or of the one in front of it
/// (separable_tiles). Grid and map must outlive it.
class NodeOwner {
 public:
  NodeOwner(const GridGeometry& grid, const TileMap& map) : grid_(grid), map_(map), separable_(separable_tiles(grid)) {}
  std::int32_t operator()(Int3 tile) const {
    for (int axis = 0; axis < 3; ++axis) tile[axis] = tile[axis] < separable_[axis] ? tile[axis] : separable_[axis] - 1;
    return map_.owner(grid_.tile_index(tile));
  }

 private:
  const GridGeometry& grid_;
  const TileMap& map_;
  Int3 separable_;
};

}  // namespace bulkley
