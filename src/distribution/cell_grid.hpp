#pragma once
// Base cells as unknowns: those of a rank's tiles, the cells of other ranks that share a node with them, and the nodes of all of
// them. Valid for one set of pools.

#include <span>
#include <unordered_map>
#include <vector>

#include "distribution/particle_grid.hpp"

namespace bulkley {

/// Cells go by an id: 64 times the number of their tile here plus their place in it; the tiles of the pool come first, so that
/// the ids of this rank's cells are the entries of CellMap::cell. Nodes go by numbers that follow each other along z.
class CellGrid {
 public:
  /// Asks the owners of cells that reach a node that this rank's cells reach, or that it owns, or a node behind a wall of `faces`
  /// whose mirror image it is. Collective.
  CellGrid(const Comm& comm, const ParticleGrid& particles, const Faces& faces);

  /// That of the pools it was made of. The same on every rank.
  GlobalIndex version() const { return version_; }
  LocalIndex n_own_ids() const { return n_own_ids_; }
  LocalIndex n_ids() const { return static_cast<LocalIndex>(tiles_.size()) * tile_nodes; }
  LocalIndex n_nodes() const { return n_nodes_; }
  /// The ids of all cells here that particles can be in, in the order of their places in the grid, z fastest.
  std::span<const LocalIndex> order() const { return order_; }

  /// Where the rows of a cell's stencil along z begin, y fastest: numbers of nodes, of which each row has stencil_width that
  /// follow each other. Not collective.
  std::span<const LocalIndex> rows(LocalIndex id) const;
  int width() const { return stencil_width(grid_.order); }
  /// The base node of a cell. Not collective.
  Int3 position(LocalIndex id) const;

  /// Nodes that all cells are known of: the only ones where sums over cells are right.
  std::span<const LocalIndex> complete_nodes() const { return complete_; }
  std::vector<Int3> complete_positions() const;
  /// A node here and its place in another array.
  struct Copy {
    LocalIndex node, other;
  };
  std::span<const Copy> owned() const { return owned_; }  ///< all active nodes of the exchange
  /// Some nodes around a periodic z axis have a second number, `node`, besides the first, `other`.
  std::span<const Copy> repeated() const { return repeated_; }
  std::span<const Copy> in_pool() const { return in_pool_; }  ///< complete nodes that other ranks own

  /// The stencil of a cell by its place in a tile. Tiles at {0, 1}^3 above that one are numbered 0 to 7, z fastest.
  struct Stencil {
    std::array<std::uint64_t, 8> nodes{};  ///< a bit for each node, by tile above
    struct Row {
      std::uint8_t above, place;
    };
    std::array<Row, 16> rows{};  ///< where its rows along z begin, stencil_width^2 of them
  };
  using Stencils = std::array<Stencil, tile_nodes>;

  /// What ranks know of each other's cells: ids of own cells that a rank wants, and of its cells here.
  struct Neighbour {
    int rank;
    std::vector<LocalIndex> wanted, received;
  };
  std::span<const Neighbour> neighbours() const { return neighbours_; }

  std::size_t memory() const;

 private:
  void find_nodes(const ParticleGrid& particles, const Faces& faces);
  void add_images(const Faces& faces);
  void ask_for_cells(const Comm& comm, const ParticleGrid& particles);
  void sort_cells();
  LocalIndex node_tile(TileIndex tile) const;
  LocalIndex node_number(const Int3& node) const;
  bool need(LocalIndex node);
  std::uint64_t cells_at_complete_nodes(TileIndex tile) const;
  void add_tiles_above(TileIndex tile, std::vector<TileIndex>& tiles) const;
  std::array<LocalIndex, 8> tiles_above(TileIndex tile, const std::vector<TileIndex>& tiles) const;
  void number_nodes();
  std::vector<LocalIndex> number_columns(const std::vector<TileIndex>& tiles, const std::vector<std::uint64_t>& reached);
  void number_column(std::span<const TileIndex> tiles, const std::uint64_t* reached, int place, LocalIndex* numbers);
  void find_rows(const std::vector<std::array<LocalIndex, 8>>& above, const std::vector<LocalIndex>& numbers);

  GlobalIndex version_;
  GridGeometry grid_;
  Stencils stencils_;
  LocalIndex n_own_ids_ = 0, n_nodes_ = 0;
  std::vector<TileIndex> tiles_;       ///< of cells: of the pool, then of other ranks
  std::vector<TileIndex> node_tiles_;  ///< with complete nodes, ascending
  std::vector<std::uint64_t> needed_;  ///< by tile of nodes: a bit for each complete node
  std::vector<LocalIndex> order_, complete_;
  std::vector<LocalIndex> rows_;  ///< stencil_width^2 by id
  std::vector<Copy> owned_, in_pool_, repeated_;
  std::vector<Neighbour> neighbours_;
};

/// What sums have got under the second numbers of nodes goes to the first. Not collective.
void fold_repeated(std::span<const CellGrid::Copy> repeated, Node* sums);
/// Under the second number as under the first. Not collective.
void repeat(std::span<const CellGrid::Copy> repeated, Node* nodes);

/// One number or several of each cell from its owner to the ranks that want it, over compact numbers of occupied cells.
class CellHalo {
 public:
  /// `number_of`: compact number by id, -1 for empty cells. Not collective.
  void connect(const CellGrid& grid, std::span<const LocalIndex> number_of);

  /// values[n * width .. ] of the cells of other ranks from their owners. Collective.
  void exchange(const Comm& comm, double* values, int width);

  /// Bytes that this rank sends of one number a cell, with the versions.
  std::size_t sent_bytes() const;

 private:
  struct Neighbour {
    int rank;
    std::vector<LocalIndex> sent, received;
  };
  GlobalIndex version_ = 0;
  std::vector<Neighbour> neighbours_;
  std::vector<double> out_, in_;
  std::vector<MPI_Request> requests_;
};

/// counts[id] of the cells of other ranks from their owners. Collective.
void exchange_counts(const Comm& comm, const CellGrid& grid, std::vector<std::int32_t>& counts);

}  // namespace bulkley
