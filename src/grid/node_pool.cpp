#include "grid/node_pool.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "bulkley/base/error.hpp"

// How the layout is made.
//
// Tiles come sorted with z fastest, so those of one column (x, y) of tiles follow each other. Node columns are grouped in
// blocks of 4 x 4, aligned as tiles are. A footprint is wider than a tile, but by less than a tile, so a node column of a
// block is reached by tiles of at most four tile columns: its own, and those before it along x, y and both. Whether the ones
// before reach it depends only on whether its index in the block is below the overlap, per axis. Each block therefore has
// only four kinds of node columns. For each kind the z-intervals of the footprints are merged once; every node column of
// the block then takes those intervals as its rows, and rows are numbered in that order.
// Last, each tile looks up the rows of its footprint. The tiles of a column ascend in z, as the rows of a node column do, so
// one walk along both serves all tiles of the column. In all the work is proportional to tiles and rows, and a sort of the
// blocks.

namespace bulkley {

namespace {

// The tiles of one tile column (x, y): tiles_[first .. last).
struct TileColumn {
  int x, y;
  std::size_t first, last;
};

struct Interval {
  int begin, end;
};

// 4 x 4 node columns, aligned as tiles are; reached by the tile columns at most one to the left and one below.
struct Block {
  int x, y;
  std::array<std::size_t, tile_width * tile_width + 1> first_row;  // of node column a * tile_width + b

  friend bool operator<(const Block& p, const Block& q) { return p.x != q.x ? p.x < q.x : p.y < q.y; }
  friend bool operator==(const Block& p, const Block& q) { return p.x == q.x && p.y == q.y; }
};

std::vector<TileColumn> columns_of(const GridGeometry& grid, const std::vector<TileIndex>& tiles) {
  std::vector<TileColumn> columns;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const Int3 at = grid.tile_coordinates(tiles[t]);
    if (columns.empty() || columns.back().x != at[0] || columns.back().y != at[1]) columns.push_back({at[0], at[1], t, t});
    columns.back().last = t + 1;
  }
  return columns;
}

std::vector<Block> blocks_of(const std::vector<TileColumn>& columns) {
  std::vector<Block> blocks;
  for (const TileColumn& column : columns)
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) blocks.push_back({column.x + a, column.y + b, {}});
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

const TileColumn* find_column(const std::vector<TileColumn>& columns, int x, int y) {
  const auto before = [](const TileColumn& p, const std::array<int, 2>& q) { return p.x != q[0] ? p.x < q[0] : p.y < q[1]; };
  const auto found = std::lower_bound(columns.begin(), columns.end(), std::array{x, y}, before);
  return found != columns.end() && found->x == x && found->y == y ? &*found : nullptr;
}

std::vector<Interval> merged(std::vector<Interval> intervals) {
  std::sort(intervals.begin(), intervals.end(), [](Interval p, Interval q) { return p.begin < q.begin; });
  std::vector<Interval> result;
  for (const Interval& next : intervals) {
    if (!result.empty() && next.begin <= result.back().end)
      result.back().end = std::max(result.back().end, next.end);
    else
      result.push_back(next);
  }
  return result;
}

}  // namespace

PoolLayout::PoolLayout(const GridGeometry& grid, std::vector<TileIndex> tiles)
    : PoolLayout(grid, std::move(tiles), footprint_width(grid.order)) {}

PoolLayout::PoolLayout(const GridGeometry& grid, std::vector<TileIndex> tiles, int width) : tiles_(std::move(tiles)) {
  if (tiles_.empty()) return;
  BULKLEY_ASSERT(std::adjacent_find(tiles_.begin(), tiles_.end(), std::greater_equal<>()) == tiles_.end());
  BULKLEY_ASSERT(tiles_.front() >= 0 && tiles_.back() < grid.n_tiles());
  const int overlap = width - tile_width;  // columns of a block that the previous tile column reaches too

  slots_ = SlotTable(tiles_);

  const std::vector<TileColumn> columns = columns_of(grid, tiles_);
  std::vector<Block> blocks = blocks_of(columns);

  // Rows, block by block. Within a block only four kinds of node column differ: those that the tile columns to the left
  // and below reach, or not.
  GlobalIndex n_nodes = 0;
  for (Block& block : blocks) {
    std::array<std::vector<Interval>, 4> kinds;
    for (int kind = 0; kind < 4; ++kind) {
      std::vector<Interval> intervals;
      for (int a = 0; a <= kind / 2; ++a)
        for (int b = 0; b <= kind % 2; ++b)
          if (const TileColumn* column = find_column(columns, block.x - a, block.y - b))
            for (std::size_t t = column->first; t < column->last; ++t) {
              const int k = grid.tile_coordinates(tiles_[t])[2] * tile_width;
              intervals.push_back({k, k + width});
            }
      kinds[kind] = merged(std::move(intervals));
    }
    for (int a = 0; a < tile_width; ++a)
      for (int b = 0; b < tile_width; ++b) {
        block.first_row[a * tile_width + b] = rows_.size();
        for (const Interval& interval : kinds[2 * (a < overlap) + (b < overlap)]) {
          const int count = interval.end - interval.begin;
          rows_.push_back(
              {block.x * tile_width + a, block.y * tile_width + b, interval.begin, count, static_cast<LocalIndex>(n_nodes)});
          n_nodes += count;
          if (n_nodes > std::numeric_limits<LocalIndex>::max())
            throw RunError("the tiles of one rank reach more than 2^31 - 1 nodes; use more ranks");
        }
      }
    block.first_row.back() = rows_.size();
  }
  n_nodes_ = static_cast<LocalIndex>(n_nodes);

  // The positions of each tile's rows. The tiles of a column ascend, so each of its node columns is walked once.
  row_offset_.resize(tiles_.size() * width * width);
  for (const TileColumn& column : columns)
    for (int i = 0; i < width; ++i)
      for (int j = 0; j < width; ++j) {
        const Block key{column.x + i / tile_width, column.y + j / tile_width, {}};
        const Block& block = *std::lower_bound(blocks.begin(), blocks.end(), key);
        std::size_t row = block.first_row[(i % tile_width) * tile_width + j % tile_width];
        for (std::size_t t = column.first; t < column.last; ++t) {
          const int k = grid.tile_coordinates(tiles_[t])[2] * tile_width;
          while (rows_[row].k + rows_[row].count < k + width) ++row;
          row_offset_[(t * width + i) * width + j] = rows_[row].offset + (k - rows_[row].k);
        }
      }
}

std::size_t PoolLayout::memory() const {
  return tiles_.capacity() * sizeof(TileIndex) + rows_.capacity() * sizeof(NodeRow) +
         row_offset_.capacity() * sizeof(LocalIndex) + slots_.memory();
}

}  // namespace bulkley
