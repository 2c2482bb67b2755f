#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "balance/diffusion.hpp"
#include "balance/graph_parts.hpp"
#include "balance/partition.hpp"
#include "balance/traffic.hpp"
#include "grid/hilbert_curve.hpp"
#include "support/tile_loads.hpp"

namespace bulkley::partition_methods_test {
namespace {

constexpr PartitionMethod free_methods[] = {PartitionMethod::hilbert, PartitionMethod::bisection, PartitionMethod::metis};

// --- Hilbert curve -----------------------------------------------------------------------------------------------------

TEST(Hilbert, VisitsEachCellOnceInStepsOfOne) {
  for (const int bits : {1, 2, 3, 5}) {
    const int n = 1 << bits;
    std::vector<Int3> at(static_cast<std::size_t>(n) * n * n, Int3{-1, -1, -1});
    for (int x = 0; x < n; ++x)
      for (int y = 0; y < n; ++y)
        for (int z = 0; z < n; ++z) {
          const std::uint64_t position = hilbert_position({x, y, z}, bits);
          ASSERT_LT(position, at.size());
          ASSERT_EQ(at[position][0], -1) << "two cells at position " << position;
          at[position] = {x, y, z};
        }
    for (std::size_t p = 1; p < at.size(); ++p) {
      int length = 0;
      for (int axis = 0; axis < 3; ++axis) length += std::abs(at[p][axis] - at[p - 1][axis]);
      ASSERT_EQ(length, 1) << "from position " << p - 1 << " with " << bits << " bits";
    }
  }
}

// Grids that fill their cube, that are stretched over a smaller one, flat ones, and one tile.
TEST(Hilbert, PlacesOfTilesAreDifferentAndNearEachOther) {
  for (const Int3& n : {Int3{16, 16, 16}, Int3{5, 5, 5}, Int3{17, 9, 20}, Int3{1, 9, 3}, Int3{1, 1, 1}}) {
    const HilbertCurve curve(n);
    std::map<Int3, Int3> along;
    for (int x = 0; x < n[0]; ++x)
      for (int y = 0; y < n[1]; ++y)
        for (int z = 0; z < n[2]; ++z) {
          const Int3 place = curve.place({x, y, z});
          for (const int digit : place) ASSERT_TRUE(digit >= 0 && digit < 1 << HilbertCurve::digit_bits);
          ASSERT_TRUE(along.emplace(place, Int3{x, y, z}).second) << x << " " << y << " " << z;
        }
    if (n[0] != n[1] || n[0] != n[2]) continue;  // the curve leaves a box that is no cube, and comes back elsewhere
    for (auto next = std::next(along.begin()), here = along.begin(); next != along.end(); ++here, ++next) {
      int length = 0;
      for (std::size_t a = 0; a < 3; ++a) length += std::abs(next->second[a] - here->second[a]);
      EXPECT_LE(length, n[0] == 16 ? 1 : 4);
    }
  }
}

TEST(Hilbert, PartsAreRunsOfTheCurve) {
  const GridGeometry grid = grid_of_cells({60, 60, 60});  // 16 tiles along each axis
  const TileLoad load = tile_load(random_load(grid, 2));
  const TileMap map = make_partition(grid, {PartitionMethod::hilbert}, load, 23).map;
  std::map<std::uint64_t, std::int32_t> along;
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile)
    along[hilbert_position(grid.tile_coordinates(tile), 4)] = map.owner(tile);
  std::int32_t last = 0;
  for (const auto& [position, p] : along) {
    EXPECT_TRUE(p == last || p == last + 1);
    last = p;
  }
  EXPECT_EQ(last, 22);
}

// --- maps of owners ---------------------------------------------------------------------------------------------------

TEST(FreePartition, EveryTileHasAnOwnerAndEveryRankWork) {
  for (const NamedLoad& named : loads_of_all_kinds())
    for (const PartitionMethod method : free_methods)
      for (const int n_ranks : {1, 2, 3, 7, 16, 30, 64}) {
        SCOPED_TRACE(testing::Message() << named.name << ", " << named.grid.n_cells[2] << " cells along z, method "
                                        << static_cast<int>(method) << ", " << n_ranks << " ranks");
        const Partition partition = make_partition(named.grid, by(method), named.load, n_ranks);
        ASSERT_EQ(partition.map.n_ranks(), n_ranks);
        ASSERT_EQ(partition.map.n_tiles(), named.grid.n_tiles());
        expect_owners_in_range(partition.map);
        ASSERT_GE(named.load.size(), static_cast<std::size_t>(n_ranks));
        EXPECT_EQ(n_without_load(partition, named.load), 0);
        // Whole tiles: no method can promise less than the mean and one tile; 2 % is where METIS' parts stop.
        const GlobalIndex heaviest = *std::max_element(named.load.weight.begin(), named.load.weight.end());
        const double tile = static_cast<double>(heaviest) * n_ranks / static_cast<double>(named.load.total());
        EXPECT_LT(uneven(partition, named.load), 1.02 + tile);
      }
}

TEST(FreePartition, AnEmptyTileJoinsANearestLoadedOne) {
  const GridGeometry grid = grid_of_cells({60, 28, 12});
  std::vector<GlobalIndex> counts(static_cast<std::size_t>(grid.n_tiles()), 0);
  const TileIndex left = grid.tile_index({1, 4, 1}), right = grid.tile_index({12, 2, 3});
  counts[static_cast<std::size_t>(left)] = counts[static_cast<std::size_t>(right)] = 100;
  const TileMap present = map_by(grid, 2, [&](TileIndex tile) { return tile == right ? 1 : 0; });
  const Partition partition = rebalanced(grid, tile_load(counts), {present, {}})[0];
  ASSERT_NE(partition.map.owner(left), partition.map.owner(right));
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
    const auto steps_to = [&](TileIndex other) {
      const Int3 a = grid.tile_coordinates(tile), b = grid.tile_coordinates(other);
      return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
    };
    if (steps_to(left) < steps_to(right)) {
      EXPECT_EQ(partition.map.owner(tile), partition.map.owner(left));
    }
    if (steps_to(left) > steps_to(right)) {
      EXPECT_EQ(partition.map.owner(tile), partition.map.owner(right));
    }
  }
}

TEST(FreePartition, AutomaticIsTheFastestOfAllOrBoxesThatAreNearlyAsFast) {
  CostModel cost;
  std::map<PartitionMethod, int> n_chosen;
  int n_rebalanced = 0, n_spread = 0;
  for (const auto& [message, byte] :
       {std::pair{0.0, 0.2}, std::pair{2000.0, 0.2}, std::pair{1e6, 0.2}, std::pair{0.0, 20.0}})
    for (const NamedLoad& named : loads_of_all_kinds())
      for (const int n_ranks : {2, 9, 40}) {
        cost.message = message;
        cost.byte = byte;
        const auto time = [&](const Partition& partition) {
          return predicted_step(predict_traffic(named.grid, partition.map, named.load), cost);
        };
        PartitionNotes notes;
        const Partition chosen =
            make_partition(named.grid, by(PartitionMethod::automatic), named.load, n_ranks, nullptr, cost, &notes);
        ++n_chosen[notes.method];
        n_rebalanced += notes.rebalanced;
        n_spread += notes.spread;
        const double slack = notes.method == PartitionMethod::ranges ? 1.02 : 1.0;
        for (const PartitionMethod method :
             {PartitionMethod::ranges, PartitionMethod::hilbert, PartitionMethod::bisection, PartitionMethod::metis}) {
          const double other = time(make_partition(named.grid, by(method), named.load, n_ranks, nullptr, cost));
          EXPECT_LE(time(chosen), slack * other);
          if (method == notes.method) {
            EXPECT_EQ(time(chosen) < other, notes.rebalanced || notes.spread);
            EXPECT_LE(time(chosen), other);
          }
        }
      }
  EXPECT_EQ(n_chosen.size(), 4u) << "the cases leave a method without a chance";
  EXPECT_EQ(n_chosen.count(PartitionMethod::automatic), 0u);
  EXPECT_GT(n_rebalanced, 0);
  EXPECT_GT(n_spread, 0);
  EXPECT_LT(n_rebalanced, n_chosen[PartitionMethod::ranges]) << "no case where the boxes are the best as they are";
}

TEST(FreePartition, MoreRanksThanLoadedTiles) {
  const GridGeometry grid = grid_of_cells({28, 28, 28});
  std::vector<GlobalIndex> counts(static_cast<std::size_t>(grid.n_tiles()), 0);
  counts[7] = 10, counts[130] = 20, counts[400] = 30;
  const TileLoad load = tile_load(counts);
  for (const PartitionMethod method : free_methods) {
    const Partition partition = make_partition(grid, by(method), load, 8);
    EXPECT_EQ(n_without_load(partition, load), 5);  // each loaded tile has a rank of its own
    expect_owners_in_range(partition.map);
  }
  const Partition chosen = make_partition(grid, by(PartitionMethod::automatic), load, 8);
  expect_owners_in_range(chosen.map);
}

TEST(FreePartition, AutomaticNeedsNoRootForManyTiles) {
  const GridGeometry grid = grid_of_cells({512, 512, 512});
  const TileLoad load = tile_load(std::vector<GlobalIndex>(static_cast<std::size_t>(grid.n_tiles()), 1));
  ASSERT_GT(load.size(), most_tiles_on_root);
  PartitionNotes notes;
  const Partition chosen = make_partition(grid, by(PartitionMethod::automatic), load, 8, nullptr, {}, &notes);
  EXPECT_EQ(notes.method, PartitionMethod::bisection);
  EXPECT_EQ(chosen.map, make_partition(grid, by(PartitionMethod::bisection), load, 8).map);
}

TEST(FreePartition, AutomaticNeedsNoRootForManyRanks) {
  const GridGeometry grid = grid_of_cells({124, 124, 124});
  const TileLoad load = tile_load(random_load(grid, 4));
  for (const int n_ranks : {most_ranks_of_root, most_ranks_of_root + 1}) {
    const Partition chosen = make_partition(grid, by(PartitionMethod::automatic), load, n_ranks);
    const Partition cuts = make_partition(grid, by(PartitionMethod::bisection), load, n_ranks);
    EXPECT_EQ(chosen.boxes.has_value(), n_ranks <= most_ranks_of_root);  // tried
    if (n_ranks > most_ranks_of_root) {
      EXPECT_EQ(chosen.map, cuts.map);
    }
  }
}

TEST(FreePartition, AutomaticMakesNoTableOfAWideEmptyBox) {
  const GridGeometry grid = grid_of_cells({4000, 4000, 64}), narrow = grid_of_cells({400, 4000, 64});
  ASSERT_GT(grid.n_tiles(), most_tiles_in_table);
  ASSERT_LT(narrow.n_tiles(), most_tiles_in_table);
  TileLoad load;  // a row of tiles a tile apart, so that many parts are better off with a nearest owner
  for (int n = 0; n < 400; ++n) {
    load.tile.push_back(n * 2);
    load.weight.push_back(1000);
    load.count.push_back(1);
    load.cells.push_back(1);
  }
  EXPECT_EQ(make_partition(grid, by(PartitionMethod::automatic), load, 8).map,
            make_partition(grid, by(PartitionMethod::bisection), load, 8).map);
  EXPECT_EQ(make_partition(grid, by(PartitionMethod::automatic), load, 8).map.memory(),
            make_partition(narrow, by(PartitionMethod::bisection), load, 8).map.memory());
}

TEST(FreePartition, NoLoadAtAllAndOneTile) {
  const GridGeometry empty = grid_of_cells({28, 28, 28}), one = grid_of_cells({4, 4, 4}, {true, true, true});
  ASSERT_EQ(one.n_tiles(), 1);
  for (const PartitionMethod method : {PartitionMethod::metis, PartitionMethod::automatic}) {
    const Partition nothing = make_partition(empty, by(method), {}, 8);
    EXPECT_EQ(nothing.map, map_of_boxes(empty, *nothing.boxes));
    const Partition single = make_partition(one, by(method), tile_load(std::vector<GlobalIndex>{9}), 1);
    EXPECT_EQ(single.map, TileMap(1, {0}));
  }
}

TEST(FreePartition, WeightsBeyond32Bits) {
  const GridGeometry grid = grid_of_cells({76, 76, 76});
  TileLoad load = tile_load(ball_load(grid));
  const Partition light = make_partition(grid, by(PartitionMethod::metis), load, 12);
  for (GlobalIndex& weight : load.weight) weight = 1'000'000'000'000'000;
  for (const PartitionMethod method : free_methods) {
    PartitionNotes notes;
    const Partition partition = make_partition(grid, by(method), load, 12, nullptr, {}, &notes);
    EXPECT_EQ(notes.method, method);
    EXPECT_EQ(n_without_load(partition, load), 0);
    EXPECT_LT(uneven(partition, load), 1.03);
  }
  EXPECT_LT(uneven(light, load), 1.03);
}

TEST(FreePartition, AnUnchangedLoadStaysWhereItIs) {
  for (const NamedLoad& named : loads_of_all_kinds())
    for (const PartitionMethod method :
         {PartitionMethod::hilbert, PartitionMethod::bisection, PartitionMethod::metis, PartitionMethod::automatic})
      for (const int n_ranks : {2, 12, 40}) {
        const Partition present = make_partition(named.grid, by(method), named.load, n_ranks);
        const Partition again = make_partition(named.grid, by(method), named.load, n_ranks, &present);
        EXPECT_EQ(n_moved(present.map, again.map, named.load), 0) << named.name << ", " << n_ranks << " ranks";
        EXPECT_EQ(again.boxes, present.boxes);
      }
}

TEST(FreePartition, PartsKeepTheNumberOfTheirLargestOverlap) {
  const GridGeometry grid = grid_of_cells({124, 60, 60});
  const TileLoad load = tile_load(ball_load(grid));
  Partition present = make_partition(grid, by(PartitionMethod::metis), load, 6);
  std::set<TileIndex> astray;
  for (std::size_t t = 0; t < load.size(); t += 17) astray.insert(load.tile[t]);
  present.map = map_by(grid, 6, [&](TileIndex tile) {  // the same parts under other numbers, and a few tiles astray
    return astray.count(tile) > 0 ? 0 : (present.map.owner(tile) + 2) % 6;
  });
  const Partition again = make_partition(grid, by(PartitionMethod::metis), load, 6, &present);
  EXPECT_GT(n_moved(present.map, again.map, load), 0);
  EXPECT_LE(n_moved(present.map, again.map, load), 512 * static_cast<GlobalIndex>(load.size() / 17 + 1));
}

// --- METIS' answers ----------------------------------------------------------------------------------------------------

using Parts = std::optional<std::vector<std::int32_t>>;

class MetisAnswer : public testing::Test {
 protected:
  GridGeometry grid = grid_of_cells({60, 60, 60});
  TileLoad load = tile_load(ball_load(grid));
  TileGraph graph = tile_graph(grid, load);

  std::string fault_of(GraphPartitioner partitioner, int n_parts = 4) {
    std::string fault;
    const Parts part = graph_parts(graph, load, n_parts, fault, partitioner);
    EXPECT_EQ(part.has_value(), fault.empty());
    return fault;
  }
};

Parts slabs(const TileGraph& graph, const std::vector<std::int32_t>&, int n_parts) {
  std::vector<std::int32_t> part;
  for (std::int32_t t = 0; t < graph.size(); ++t)
    part.push_back(static_cast<std::int32_t>(GlobalIndex{t} * n_parts / graph.size()));
  return part;
}

TEST_F(MetisAnswer, IsTakenIfItWillDo) { EXPECT_EQ(fault_of(slabs), ""); }

TEST_F(MetisAnswer, Error) {
  EXPECT_EQ(fault_of([](const TileGraph&, const std::vector<std::int32_t>&, int) { return Parts{}; }),
            "it reports an error");
}

TEST_F(MetisAnswer, EmptyPart) {
  const GraphPartitioner without_the_last = [](const TileGraph& g, const std::vector<std::int32_t>& w, int n) {
    return slabs(g, w, n - 1);
  };
  EXPECT_EQ(fault_of(without_the_last), "it leaves 1 of 4 parts empty");
}

TEST_F(MetisAnswer, PartOutOfRange) {
  const GraphPartitioner above = [](const TileGraph& g, const std::vector<std::int32_t>& w, int n) {
    Parts part = slabs(g, w, n);
    part->back() = n;
    return part;
  };
  const GraphPartitioner below = [](const TileGraph& g, const std::vector<std::int32_t>& w, int n) {
    Parts part = slabs(g, w, n);
    part->front() = -1;
    return part;
  };
  EXPECT_EQ(fault_of(above), "it names a part 4 of 4");
  EXPECT_EQ(fault_of(below), "it names a part -1 of 4");
}

TEST_F(MetisAnswer, ScatteredParts) {
  const GraphPartitioner in_turn = [](const TileGraph& g, const std::vector<std::int32_t>&, int n) {
    std::vector<std::int32_t> part;
    for (std::int32_t t = 0; t < g.size(); ++t) part.push_back(t * 7919 % 101 % n);
    return Parts(part);
  };
  const std::string fault = fault_of(in_turn, 12);
  EXPECT_EQ(fault.substr(0, 17), "its 12 parts are ") << fault;
}

// From 8e7 tiles on, which is 4e10 particles, eight to a cell.
TEST_F(MetisAnswer, IsNotAskedForWhatItCannotNumber) {
  const GraphPartitioner fails = [](const TileGraph&, const std::vector<std::int32_t>&, int) { return Parts{}; };
  graph.first.back() = std::numeric_limits<std::int32_t>::max();
  EXPECT_EQ(fault_of(fails), "it reports an error");  // was asked
  graph.first.back() += 1;
  EXPECT_EQ(fault_of(fails),
            std::to_string(load.size()) + " tiles have 2147483648 neighbours, more than it numbers in 32 bits");
}

TEST_F(MetisAnswer, WeightsFitIn32BitsTogether) {
  for (GlobalIndex& weight : load.weight) weight = 900'000'000'000'000 + weight;
  fault_of([](const TileGraph& g, const std::vector<std::int32_t>& weights, int n) {
    GlobalIndex total = 0;
    for (const std::int32_t weight : weights) {
      EXPECT_GT(weight, 1000);
      total += weight;
    }
    EXPECT_LT(total, GlobalIndex{1} << 31);
    EXPECT_GT(total, GlobalIndex{1} << 29);  // nor is precision given away
    return slabs(g, weights, n);
  });
}

TEST_F(MetisAnswer, TooFewTilesFallBackToTheCurveWithAWarning) {
  const int n_ranks = 90;  // three tiles each, roughly
  PartitionNotes notes;
  const Partition partition = make_partition(grid, by(PartitionMethod::metis), load, n_ranks, nullptr, {}, &notes);
  EXPECT_EQ(notes.method, PartitionMethod::hilbert);
  ASSERT_EQ(notes.warnings.size(), 1u);
  const std::string expected = "METIS cannot divide the tiles (" + std::to_string(load.size()) +
                               " tiles hold particles, fewer than 4 for each of " + std::to_string(n_ranks) +
                               " ranks); they are cut along a Hilbert curve";
  EXPECT_EQ(notes.warnings[0], expected);
  EXPECT_EQ(partition.map, make_partition(grid, by(PartitionMethod::hilbert), load, n_ranks).map);
}

TEST(Rebalanced, KeepsTheOwnersAndMovesLittle) {
  const GridGeometry grid = grid_of_cells({124, 124, 124});
  TileLoad load = tile_load(ball_load(grid));
  const Partition present = make_partition(grid, by(PartitionMethod::metis), load, 16);
  for (std::size_t t = 0; t < load.size(); ++t)
    if (present.map.owner(load.tile[t]) == 5) load.weight[t] += load.weight[t] / 5;
  const Partition after = rebalanced(grid, load, present)[0];
  EXPECT_EQ(after.boxes, present.boxes);
  EXPECT_LE(uneven(after, load), 1.02);
  EXPECT_GT(uneven(present, load), 1.15);
  EXPECT_LT(n_moved(present.map, after.map, load), 512 * static_cast<GlobalIndex>(load.size()) / 20);
}

}  // namespace
}  // namespace bulkley::partition_methods_test
