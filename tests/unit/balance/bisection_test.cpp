#include "balance/bisection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <set>

#include "balance/partition.hpp"
#include "balance/traffic.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::bisection_test {
namespace {

/// As owners are defined: down the cuts, one after the other.
int owner_by_cuts(const CutTree& tree, const Int3& tile, int first, int n) {
  if (n == 1) return first;
  const int below = tree.halves().n_below(n);
  if (tree.cuts()[tree.halves().cut_of(first, n)].below(tile)) return owner_by_cuts(tree, tile, first, below);
  return owner_by_cuts(tree, tile, first + below, n - below);
}

std::vector<TileLoad> loads_of(const GridGeometry& grid) {
  return {tile_load(random_load(grid, 5)), tile_load(ball_load(grid)), tile_load(scattered_load(grid))};
}

TEST(CutTreeTest, BelowIsWhatComesBeforeTheThreshold) {
  const Cut cut(1, {3, 5, 2});  // along y, then z, then x
  EXPECT_EQ(cut.axis(), 1);
  EXPECT_TRUE(cut.below({9, 4, 9}));
  EXPECT_TRUE(cut.below({9, 5, 1}));
  EXPECT_TRUE(cut.below({2, 5, 2}));
  EXPECT_FALSE(cut.below({3, 5, 2}));
  EXPECT_FALSE(cut.below({0, 5, 3}));
  EXPECT_FALSE(cut.below({0, 6, 0}));
  EXPECT_EQ(Cut::of_bits(cut.bits()), cut);
  const int last = (1 << 18) + 1;  // of the largest grid
  EXPECT_TRUE(Cut(2, {last, last, last}).below({last, last - 1, last}));
  EXPECT_FALSE(Cut(2, {last, last, last}).below({last, last, last}));
}

TEST(CutTreeTest, EveryTileHasTheOwnerThatTheCutsName) {
  const GridGeometry grid = grid_of_cells({30, 50, 40});
  for (const TileLoad& load : loads_of(grid))
    for (const auto& [n_ranks, ranks_per_node] :
         {std::pair{1, 1}, {2, 1}, {3, 1}, {5, 1}, {8, 1}, {13, 1}, {31, 1}, {8, 3}, {13, 4}, {31, 31}, {31, 5}}) {
      const CutTree tree = bisected(grid, Cutting::planes, load, n_ranks, {}, {ranks_per_node});
      const TileMap map{tree};
      std::vector<std::int32_t> table;
      for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
        ASSERT_EQ(map.owner(tile), owner_by_cuts(tree, grid.tile_coordinates(tile), 0, n_ranks));
        table.push_back(map.owner(tile));
      }
      EXPECT_EQ(map.n_ranks(), n_ranks);
      EXPECT_EQ(map.n_tiles(), grid.n_tiles());
      EXPECT_EQ(map.memory(), 8 * static_cast<std::size_t>(n_ranks - 1));
      EXPECT_EQ(map, TileMap(n_ranks, table));
      EXPECT_EQ(TileMap(n_ranks, table), map);
      EXPECT_EQ(TileMap::unpack(n_ranks, TileMap(map).pack()), map);
      EXPECT_EQ(TileMap::unpack(n_ranks, TileMap(map).pack()).fingerprint(), map.fingerprint());
      table[7] = (table[7] + 1) % n_ranks;
      EXPECT_EQ(map == TileMap(n_ranks, table), n_ranks == 1);
      if (n_ranks == 1) continue;
      std::vector<Cut> cuts = tree.cuts();
      cuts.back() = Cut::of_bits(cuts.back().bits() + 1);
      EXPECT_NE(TileMap(CutTree(grid, cuts, Cutting::planes, tree.halves())).fingerprint(), map.fingerprint());
      EXPECT_NE(TileMap(CutTree(grid, tree.cuts(), Cutting::planes, {ranks_per_node + 1})).fingerprint(), map.fingerprint());
    }
}

/// Every region of more than one node is halved between nodes, and no half is empty.
void expect_whole_nodes(RankHalves halves, int first, int n, int& deepest, int depth) {
  deepest = std::max(deepest, depth);
  if (n == 1) return;
  const int below = halves.n_below(n);
  ASSERT_GT(below, 0);
  ASSERT_LT(below, n);
  if (n > halves.ranks_per_node)
    EXPECT_EQ((first + below) % halves.ranks_per_node, 0) << n << " ranks from " << first << " on";
  else
    EXPECT_EQ(below, n / 2);
  expect_whole_nodes(halves, first, below, deepest, depth + 1);
  expect_whole_nodes(halves, first + below, n - below, deepest, depth + 1);
}

TEST(RankHalvesTest, RegionsOfSeveralNodesAreHalvedBetweenNodes) {
  for (const int ranks_per_node : {1, 2, 3, 7, 48, 96, 128})
    for (const int n_ranks : {1, 2, 3, 6, 7, 47, 48, 49, 97, 288, 384, 480, 513, 100'000}) {
      int deepest = 0;
      expect_whole_nodes({ranks_per_node}, 0, n_ranks, deepest, 0);
      EXPECT_LE(deepest, std::bit_width(static_cast<unsigned>(n_ranks)) + 2) << n_ranks << ", " << ranks_per_node;
    }
}

// Where halves in the middle of all ranks do not meet the nodes.
TEST(BisectionTest, FewerBytesLeaveNodesThatAreWhole) {
  const GridGeometry grid = grid_of_cells({124, 124, 124});
  const TileLoad load = tile_load(ball_load(grid));
  const auto off_node = [&](int n_nodes, int ranks_per_node, RankHalves halves) {
    const TileMap map{bisected(grid, Cutting::planes, load, n_nodes * ranks_per_node, {}, halves)};
    GlobalIndex bytes = 0;
    for (const RankTraffic& rank : predict_traffic(grid, map, load, ranks_per_node)) bytes += rank.bytes_off_node;
    EXPECT_LT(imbalance(rank_loads(map, load)), 1.1);
    return static_cast<double>(bytes);
  };
  for (const int n_nodes : {3, 5, 6, 7}) EXPECT_LT(off_node(n_nodes, 12, {12}), 0.9 * off_node(n_nodes, 12, {})) << n_nodes;
  EXPECT_EQ(off_node(4, 16, {16}), off_node(4, 16, {}));
}

// Each level errs by half a tile at most, which its ranks share: 1/2 + 1/4 + ... of a tile.
TEST(BisectionTest, LoadsAreEvenToWithinATile) {
  const GridGeometry grid = grid_of_cells({124, 60, 92});
  for (const TileLoad& load : loads_of(grid))
    for (const int n_ranks : {2, 3, 7, 16, 37, 64, 101}) {
      const std::vector<GlobalIndex> of_rank = rank_loads(TileMap(bisected(grid, Cutting::planes, load, n_ranks)), load);
      const auto mean = static_cast<double>(load.total()) / n_ranks;
      const auto heaviest = static_cast<double>(*std::max_element(load.weight.begin(), load.weight.end()));
      for (const GlobalIndex l : of_rank) EXPECT_NEAR(static_cast<double>(l), mean, heaviest) << n_ranks << " ranks";
    }
}

TEST(BisectionTest, NoRankStarvesBesideOneWithManyTiles) {
  const GridGeometry grid = grid_of_cells({60, 60, 60});
  TileLoad load = tile_load(ball_load(grid));
  for (const int n_ranks : {2, 5, 16, 40}) {  // one tile outweighs all others
    load.weight[load.size() / 3] = 1'000'000'000;
    const Partition partition{TileMap(bisected(grid, Cutting::planes, load, n_ranks)), {}};
    EXPECT_EQ(n_without_load(partition, load), 0) << n_ranks;
  }
  std::vector<GlobalIndex> counts(static_cast<std::size_t>(grid.n_tiles()), 0);
  counts[7] = 10, counts[130] = 20, counts[400] = 30, counts[401] = 1;
  const TileLoad few = tile_load(counts);
  for (const int n_ranks : {4, 5, 8, 31})
    EXPECT_EQ(n_without_load({TileMap(bisected(grid, Cutting::planes, few, n_ranks)), {}}, few), n_ranks - 4) << n_ranks;
}

TEST(BisectionTest, LoadsBeyond63BitsTogetherWithRanksAreDividedRight) {
  const GridGeometry grid = grid_of_cells({60, 60, 60});
  TileLoad load = tile_load(ball_load(grid));
  const CutTree light = bisected(grid, Cutting::planes, load, 48);
  const GlobalIndex factor = (GlobalIndex{1} << 62) / load.total();
  for (GlobalIndex& weight : load.weight) weight *= factor;
  ASSERT_GT(load.total(), GlobalIndex{1} << 60);
  EXPECT_EQ(bisected(grid, Cutting::planes, load, 48), light);
}

// The empty space between two bodies is cut in its middle, a plate across its length.
TEST(BisectionTest, CutsWhereFewestFootprintsReachAcross) {
  const GridGeometry grid = grid_of_cells({124, 60, 60});
  const auto of_tiles = [&](const auto& holds) {
    std::vector<GlobalIndex> counts(static_cast<std::size_t>(grid.n_tiles()), 0);
    for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) counts[tile] = holds(grid.tile_coordinates(tile)) ? 9 : 0;
    return tile_load(counts);
  };
  const TileLoad drops = of_tiles([](const Int3& at) { return (at[0] == 5 || at[0] == 16) && at[1] < 3 && at[2] < 5; });
  EXPECT_EQ(bisected(grid, Cutting::planes, drops, 2).cuts()[0], Cut(0, {11, 0, 0}));
  const TileLoad plate = of_tiles([](const Int3& at) { return at[0] < 4 && at[1] < 3 && at[2] < 14; });
  EXPECT_EQ(bisected(grid, Cutting::planes, plate, 2).cuts()[0], Cut(2, {0, 0, 7}));
  EXPECT_EQ(bisected(grid, Cutting::planes, plate, 3).cuts()[0],
            Cut(2, {2, 2, 4}));  // a third of 14 layers of 12 tiles: 56 of 168
  // Two plates face to face are cut apart, although they are longer than far apart.
  const TileLoad plates = of_tiles([](const Int3& at) { return at[0] < 12 && (at[1] == 0 || at[1] == 10) && at[2] < 3; });
  EXPECT_EQ(bisected(grid, Cutting::planes, plates, 2).cuts()[0], Cut(1, {0, 5, 0}));
  // A column of 2 x 2 on a foot: a cut through the column has 4 faces, one along it cuts all its layers.
  const TileLoad column = of_tiles([](const Int3& at) {
    return (at[2] == 0 && at[0] < 9 && at[1] < 4) || (at[2] > 0 && at[2] < 13 && at[0] < 2 && at[1] < 2);
  });
  EXPECT_EQ(bisected(grid, Cutting::planes, column, 4).cuts()[1].axis(), 2);
  const TileLoad cube = of_tiles([](const Int3& at) { return at[0] < 8 && at[1] < 8 && at[2] < 8; });
  EXPECT_EQ(bisected(grid, Cutting::planes, cube, 2).cuts()[0], Cut(0, {4, 0, 0}));
}

TEST(BisectionTest, TheOrderOfTilesDoesNotMatter) {
  const GridGeometry grid = grid_of_cells({60, 44, 52});
  std::mt19937 random(8);
  for (const TileLoad& load : loads_of(grid)) {
    std::vector<TileRecord> records = records_of(grid, Cutting::planes, load);
    WholeRegion whole;
    for (const int n_ranks : {2, 9, 64}) {
      const Bisection bisection(grid, Cutting::planes, {}, n_ranks, load.total());
      const Cut cut = bisection.cut(records, 0, n_ranks, 0, whole);
      std::shuffle(records.begin(), records.end(), random);
      EXPECT_EQ(bisection.cut(records, 0, n_ranks, 0, whole), cut);
    }
  }
}

TEST(BisectionTest, CutsStayWhereTheyServe) {
  const GridGeometry grid = grid_of_cells({252, 124, 124});
  const TileLoad before = tile_load(ball_load(grid));
  constexpr int n_ranks = 64;
  const CutTree present = bisected(grid, Cutting::planes, before, n_ranks);
  for (const double tolerance : {0.0, KeptCuts::tight_tolerance, KeptCuts::usual_tolerance})
    EXPECT_EQ(bisected(grid, Cutting::planes, before, n_ranks, {&present, std::max(tolerance, 0.02)}), present);

  TileLoad after = before;  // heavier towards one side
  for (std::size_t t = 0; t < after.size(); ++t) after.weight[t] += 4 * grid.tile_coordinates(after.tile[t])[2];
  const auto mean = static_cast<double>(after.total()) / n_ranks;
  const auto heaviest = static_cast<double>(*std::max_element(after.weight.begin(), after.weight.end()));
  const auto moved = [&](const CutTree& tree) { return n_moved(TileMap(present), TileMap(tree), after); };
  const CutTree anew = bisected(grid, Cutting::planes, after, n_ranks);
  GlobalIndex last = moved(anew);
  ASSERT_GT(imbalance(rank_loads(TileMap(present), after)), 1.06);
  for (const double tolerance : {KeptCuts::tight_tolerance, KeptCuts::usual_tolerance}) {
    const CutTree kept = bisected(grid, Cutting::planes, after, n_ranks, {&present, tolerance});
    for (const GlobalIndex load : rank_loads(TileMap(kept), after))
      EXPECT_LE(static_cast<double>(load), (1.0 + tolerance) * mean + heaviest);
    EXPECT_LT(moved(kept), last) << "tolerance " << tolerance;
    last = moved(kept);
  }
  EXPECT_GT(last, 0);

  // A cut with too few tiles for the ranks of a side does not serve, however light they are.
  TileLoad few = before;
  for (std::size_t t = 0; t < few.size(); ++t) few.weight[t] = 1;
  const CutTree lopsided(grid, std::vector<Cut>(n_ranks - 1));
  EXPECT_EQ(n_without_load({TileMap(bisected(grid, Cutting::planes, few, n_ranks, {&lopsided, 1e9})), {}}, few), 0);
}

// Without kept cuts the axis stays as long as another has nearly as many faces.
TEST(BisectionTest, AxesStayWhereOthersAreHardlyBetter) {
  const GridGeometry grid = grid_of_cells({124, 60, 60});
  for (const auto& [height, axis] :
       {std::pair{9, 1}, std::pair{12, 0}}) {  // of a block 8 tiles long and wide, cut across y so far
    std::vector<GlobalIndex> counts(static_cast<std::size_t>(grid.n_tiles()), 0);
    for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
      const Int3 at = grid.tile_coordinates(tile);
      counts[tile] = at[0] < height && at[1] < 8 && at[2] < 8 ? 9 : 0;
    }
    const TileLoad load = tile_load(counts);
    EXPECT_EQ(bisected(grid, Cutting::planes, load, 2).cuts()[0].axis(), 0);
    const CutTree present(grid, {Cut(1, {0, 1, 0})});
    EXPECT_EQ(bisected(grid, Cutting::planes, load, 2, {&present, KeptCuts::no_tolerance}).cuts()[0].axis(), axis);
  }
}

TEST(BisectionTest, WithoutLoadTheGridIsCutEvenly) {
  const GridGeometry grid = grid_of_cells({124, 60, 60});
  for (const int n_ranks : {1, 2, 3, 8, 30}) {
    const TileMap map{bisected(grid, Cutting::planes, {}, n_ranks)};
    const TileLoad all = tile_load(std::vector<GlobalIndex>(static_cast<std::size_t>(grid.n_tiles()), 1));
    EXPECT_LT(imbalance(rank_loads(map, all)), 1.3) << n_ranks;
    const CutTree other(grid, std::vector<Cut>(static_cast<std::size_t>(n_ranks - 1), Cut(2, {1, 2, 3})));
    EXPECT_EQ(bisected(grid, Cutting::planes, {}, n_ranks, {&other}), other);
  }
}

}  // namespace
}  // namespace bulkley::bisection_test
