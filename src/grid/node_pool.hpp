#pragma once
// A rank's merged pool of nodes: the union of the footprints of its tiles, each node once.
//
// Layout. For every column (I, J) of nodes the pool holds the z-intervals that some tile reaches, each interval contiguous
// in z ("row"). A tile's footprint is footprint_width^2 such rows, so a table of row offsets per tile turns a node of the
// footprint into a pool index: row_offset[slot][i * w + j] + k. A scattered set of tiles thus costs only its own nodes.

#include <new>
#include <span>
#include <vector>

#include "grid/grid_geometry.hpp"
#include "grid/slot_table.hpp"

namespace bulkley {

/// Mass and momentum (or velocity) of one node, the unit of every exchange: {x, y, z, mass}. No more than a double's
/// alignment may be assumed: PETSc's vectors hold nodes too.
struct Node {
  double c[4];
};

/// A node of schemes that sum forces apart from momenta: {m v, m} and {dt f, -}, then {v, m} and {the change of v, -}. A cache
/// line.
struct NodePair {
  Node motion, change;
};

/// Storage that starts on a cache line, so that no node straddles two.
template <class T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t alignment{64};
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), alignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, alignment); }
  friend bool operator==(CacheLineAllocator, CacheLineAllocator) { return true; }
};
using NodeVector = std::vector<Node, CacheLineAllocator<Node>>;
using NodePairVector = std::vector<NodePair, CacheLineAllocator<NodePair>>;

/// Room for `n` values, which are undefined afterwards. Where there is not enough the old memory goes before the new one is taken, so
/// that the two are never there together; a little more than `n` is reserved, because material goes on spreading. Not collective.
template <class Vector>
void renew(Vector& values, std::size_t n) {
  if (n > values.capacity()) {
    values = Vector();
    values.reserve(n + n / 16);
  }
  values.resize(n);
}

/// A contiguous run of pool nodes: (i, j, k .. k + count - 1) in grid indices (not yet wrapped), at pool index `offset`.
struct NodeRow {
  int i, j, k;
  int count;
  LocalIndex offset;
};

/// The positions of the nodes of a set of tiles in the pool. Not collective.
class PoolLayout {
 public:
  PoolLayout() = default;
  /// `tiles`: ascending, each once. The nodes are those of their footprints, or the first `width` along each axis from the
  /// first of each tile.
  PoolLayout(const GridGeometry& grid, std::vector<TileIndex> tiles);
  PoolLayout(const GridGeometry& grid, std::vector<TileIndex> tiles, int width);

  const std::vector<TileIndex>& tiles() const { return tiles_; }
  const std::vector<NodeRow>& rows() const { return rows_; }
  LocalIndex n_nodes() const { return n_nodes_; }
  /// Position of `tile` in tiles(), or -1.
  LocalIndex slot(TileIndex tile) const { return slots_.slot(tile); }
  /// width^2 offsets per slot.
  std::span<const LocalIndex> row_offsets() const { return row_offset_; }
  std::size_t memory() const;

 private:
  std::vector<TileIndex> tiles_;
  std::vector<NodeRow> rows_;
  std::vector<LocalIndex> row_offset_;
  SlotTable slots_;
  LocalIndex n_nodes_ = 0;
};

}  // namespace bulkley
