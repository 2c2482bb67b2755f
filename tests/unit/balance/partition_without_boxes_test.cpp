// Numbers of ranks that the tiles of a grid do not make boxes for, and more ranks than there are tiles.
#include <gtest/gtest.h>

#include <algorithm>

#include "balance/partition.hpp"
#include "balance/traffic.hpp"
#include "bulkley/base/error.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::partition_without_boxes_test {
namespace {

constexpr PartitionMethod all_free_methods[] = {PartitionMethod::hilbert, PartitionMethod::bisection, PartitionMethod::metis,
                                                PartitionMethod::automatic};

TEST(WithoutBoxes, EveryRankHasWorkWhileThereAreTiles) {
  for (const GridGeometry& grid : {grid_of_cells({8, 8, 8}), grid_of_cells({12, 12, 12}, {true, true, true})}) {
    ASSERT_EQ(grid.n_tiles(), 27);
    const TileLoad load = tile_load(std::vector<GlobalIndex>(27, 300));
    for (const int n_ranks : {5, 7, 11, 26, 27, 28, 40, 1000})
      for (const PartitionMethod method : all_free_methods) {
        SCOPED_TRACE(testing::Message() << n_ranks << " ranks, method " << static_cast<int>(method));
        if (box_fault(grid, n_ranks).empty()) continue;  // 27: a box is a tile
        PartitionNotes notes;
        const Partition partition = make_partition(grid, by(method), load, n_ranks, nullptr, {}, &notes);
        EXPECT_EQ(partition.map.n_ranks(), n_ranks);
        EXPECT_FALSE(partition.boxes);
        EXPECT_TRUE(notes.method == PartitionMethod::hilbert || notes.method == PartitionMethod::bisection ||
                    notes.method == PartitionMethod::metis);
        ASSERT_EQ(partition.map.n_tiles(), 27);
        expect_owners_in_range(partition.map);
        EXPECT_EQ(n_without_load(partition, load), std::max(0, n_ranks - 27));
        EXPECT_LE(uneven(partition, load), (27 + n_ranks - 1) / n_ranks * n_ranks / 27.0 + 1e-12);  // whole tiles

        // The same load again, and few tiles moved: nothing there needs boxes.
        const Partition again = make_partition(grid, by(method), load, n_ranks, &partition);
        EXPECT_EQ(n_moved(partition.map, again.map, load), 0);
        for (const Partition& moved : rebalanced(grid, load, partition)) {
          EXPECT_EQ(moved.map.n_ranks(), n_ranks);
          EXPECT_LE(uneven(moved, load), uneven(partition, load));
        }
      }
  }
}

TEST(WithoutBoxes, RanksWithoutTilesTakeSomeOver) {
  const GridGeometry grid = grid_of_cells({8, 8, 8});
  const TileLoad load = tile_load(std::vector<GlobalIndex>(27, 300));
  Partition present = make_partition(grid, by(PartitionMethod::hilbert), load, 40);
  present.map = map_to(grid, 40, 39);
  EXPECT_EQ(n_without_load(make_partition(grid, by(PartitionMethod::automatic), load, 40, &present), load), 13);
  EXPECT_LE(n_without_load(rebalanced(grid, load, present)[1], load), 20);
}

TEST(WithoutBoxes, OneTile) {
  const GridGeometry grid = grid_of_cells({4, 4, 4}, {true, true, true});
  const TileLoad load = tile_load(std::vector<GlobalIndex>{9});
  for (const PartitionMethod method : all_free_methods) {
    const Partition partition = make_partition(grid, by(method), load, 3);
    EXPECT_FALSE(partition.boxes);
    EXPECT_EQ(n_without_load(partition, load), 2);
    EXPECT_EQ(predict_traffic(grid, partition.map, load).size(), 3u);
  }
  for (const PartitionMethod method : {PartitionMethod::uniform, PartitionMethod::ranges})
    EXPECT_THROW(make_partition(grid, by(method), load, 2), UsageError);
}

// Empty space is shared out all the same: particles may come.
TEST(WithoutBoxes, NoLoadAtAll) {
  const GridGeometry grid = grid_of_cells({8, 8, 8});
  const TileLoad all = tile_load(std::vector<GlobalIndex>(27, 1));
  for (const PartitionMethod method : all_free_methods) {
    const Partition partition = make_partition(grid, by(method), {}, 5);
    EXPECT_EQ(n_without_load(partition, all), 0);
    EXPECT_LE(uneven(partition, all), 8.0 * 5 / 27 + 1e-12);  // plane cuts leave blocks of 2 x 2 x 2 tiles
  }
}

}  // namespace
}  // namespace bulkley::partition_without_boxes_test
