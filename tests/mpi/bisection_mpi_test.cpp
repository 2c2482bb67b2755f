// ranks: 1 3 8 32
// Bisection of space and of the curve without a root: the tree of one process, tile for tile, on any number of ranks, and what it
// takes.
#include "rebalance/bisection_partitioner.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <new>
#include <random>
#include <set>

#include "support/tile_loads.hpp"

namespace {

// Bytes asked for by `new`, and the most at one time since it was set back. MPI's own are not among them.
std::size_t n_bytes = 0, most_bytes = 0;
constexpr std::size_t head = alignof(std::max_align_t);  // where the size of a piece is kept

}  // namespace

void* operator new(std::size_t size) {
  auto* const piece = static_cast<char*>(std::malloc(size + head));
  if (!piece) throw std::bad_alloc();
  *reinterpret_cast<std::size_t*>(piece) = size;
  n_bytes += size;
  most_bytes = std::max(most_bytes, n_bytes);
  return piece + head;
}
void operator delete(void* pointer) noexcept {
  if (!pointer) return;
  char* const piece = static_cast<char*>(pointer) - head;
  n_bytes -= *reinterpret_cast<std::size_t*>(piece);
  std::free(piece);
}
void operator delete(void* pointer, std::size_t) noexcept { operator delete(pointer); }

namespace bulkley::bisection_mpi_test {
namespace {

/// Some ranks of the world by themselves: 1 to all of them, even, odd and prime numbers; in a world of more than eight, more than
/// eight, for smaller ones have what is below.
class RankNumbers : public testing::Test {
 protected:
  Comm world{PETSC_COMM_WORLD};

  template <class Work>
  void for_each_number(const Work& work) {
    for (const int n : {1, 2, 3, 4, 5, 7, 8, 13, 16, 31, 37, 64}) {
      if (n > world.size() || (n <= 8 && world.size() > 8)) continue;
      MPI_Comm part = MPI_COMM_NULL;
      BULKLEY_MPI(MPI_Comm_split(world.get(), world.rank() < n ? 0 : MPI_UNDEFINED, world.rank(), &part));
      if (part == MPI_COMM_NULL) continue;
      SCOPED_TRACE(testing::Message() << n << " ranks");
      {
        const Comm comm(part);
        work(comm);
      }
      BULKLEY_MPI(MPI_Comm_free(&part));
    }
  }
};

/// The tree is the same on every rank, and on the root the one that a process by itself makes.
template <class Make>
void expect_tree(const Comm& comm, const CutTree& tree, const Make& make) {
  const auto hash = static_cast<GlobalIndex>(TileMap(tree).fingerprint() >> 1);
  EXPECT_EQ(min_global(comm, hash), max_global(comm, hash));
  if (comm.is_root()) {
    EXPECT_EQ(tree, make());
  }
}

struct NamedLoad {
  GridGeometry grid;
  TileLoad load;
};
std::vector<NamedLoad> all_loads() {
  std::vector<NamedLoad> result;
  const GridGeometry grid = grid_of_cells({60, 76, 44}), wide = grid_of_cells({1100, 700, 4});
  for (const std::vector<GlobalIndex>& counts : {random_load(grid, 3), ball_load(grid), scattered_load(grid)})
    result.push_back({grid, tile_load(counts)});
  result.push_back({wide, tile_load(ball_load(wide))});
  std::vector<GlobalIndex> few(static_cast<std::size_t>(grid.n_tiles()), 0);
  for (int n = 0; n < 11; ++n) few[static_cast<std::size_t>(100 + 131 * n)] = 1 + n;
  result.push_back({grid, tile_load(few)});
  result.push_back({grid, {}});
  return result;
}

constexpr Cutting all_cuttings[] = {Cutting::planes, Cutting::curve};

/// The records that a rank begins with: at random, or all with one rank.
std::vector<TileRecord> share(const Comm& comm, Cutting cutting, const NamedLoad& named, bool all_with_last) {
  std::vector<TileRecord> records;
  std::mt19937 random(1);
  for (const TileRecord& record : records_of(named.grid, cutting, named.load)) {
    const int owner = all_with_last ? comm.size() - 1 : static_cast<int>(random() % static_cast<unsigned>(comm.size()));
    if (owner == comm.rank()) records.push_back(record);
  }
  std::shuffle(records.begin(), records.end(), random);
  return records;
}

TEST_F(RankNumbers, TheTreeIsThatOfOneProcess) {
  for_each_number([&](const Comm& comm) {
    for (const Cutting cutting : all_cuttings)
      for (const NamedLoad& named : all_loads())
        for (const bool all_with_last : {false, true}) {
          std::vector<TileRecord> records = share(comm, cutting, named, all_with_last);
          SentMessages sent;
          const CutTree tree = bisected_together(comm, named.grid, cutting, records, {}, sent);
          expect_tree(comm, tree, [&] { return bisected(named.grid, cutting, named.load, comm.size()); });
          // Each rank is left with its own tiles.
          const TileMap map{tree};
          std::set<Int3> found, expected;
          for (const TileRecord& record : records) found.insert(record.at);
          for (const TileRecord& record : records_of(named.grid, cutting, named.load))
            if (tree.owner_of_place(record.at) == comm.rank()) expected.insert(record.at);
          EXPECT_EQ(records.size(), found.size());
          EXPECT_EQ(found, expected);
          std::size_t n_owned = 0;
          for (const TileIndex tile : named.load.tile) n_owned += map.owner(tile) == comm.rank();
          EXPECT_EQ(n_owned, expected.size());
        }
  });
}

TEST_F(RankNumbers, NodesAreHalvedFirstLikeInOneProcess) {
  for_each_number([&](const Comm& comm) {
    for (const Cutting cutting : all_cuttings)
      for (const RankHalves halves : {RankHalves{3}, RankHalves{4}, RankHalves{6}}) {
        const NamedLoad named = all_loads()[1];
        std::vector<TileRecord> records = share(comm, cutting, named, false);
        SentMessages sent;
        const CutTree tree = bisected_together(comm, named.grid, cutting, records, {}, sent, halves);
        expect_tree(comm, tree, [&] { return bisected(named.grid, cutting, named.load, comm.size(), {}, halves); });
        EXPECT_EQ(tree.halves(), halves);
        const auto n_here = static_cast<GlobalIndex>(records.size());
        for (const TileRecord& record : records) EXPECT_EQ(tree.owner_of_place(record.at), comm.rank());
        EXPECT_EQ(sum_global(comm, n_here), static_cast<GlobalIndex>(named.load.size()));
      }
  });
}

TEST_F(RankNumbers, KeptCutsAreThoseOfOneProcess) {
  for_each_number([&](const Comm& comm) {
    for (const Cutting cutting : all_cuttings)
      for (const NamedLoad& before : all_loads()) {
        SentMessages first;
        std::vector<TileRecord> all = share(comm, cutting, before, false);
        const CutTree present = bisected_together(comm, before.grid, cutting, all, {}, first);
        NamedLoad after = before;
        for (std::size_t t = 0; t < after.load.size(); ++t)
          after.load.weight[t] += after.load.weight[t] * after.grid.tile_coordinates(after.load.tile[t])[1] / 100;
        for (const double tolerance : {KeptCuts::tight_tolerance, KeptCuts::usual_tolerance}) {
          std::vector<TileRecord> records = share(comm, cutting, after, false);
          SentMessages sent;
          const KeptCuts kept{&present, tolerance};
          const CutTree tree = bisected_together(comm, after.grid, cutting, records, kept, sent);
          expect_tree(comm, tree, [&] { return bisected(after.grid, cutting, after.load, comm.size(), kept); });
        }
      }
  });
}

// With r rounds of the search in the largest region there are r + 3 sums at each of L levels, of log2 of its ranks messages each
// (one more below a number that is no power of two), and a message with tiles.
TEST_F(RankNumbers, MessagesGrowWithTheSquareOfTheLogarithm) {
  for_each_number([&](const Comm& comm) {
    const NamedLoad named = all_loads()[1];
    std::vector<TileRecord> records = share(comm, Cutting::planes, named, false);
    SentMessages sent;
    bisected_together(comm, named.grid, Cutting::planes, records, {}, sent);
    const GlobalIndex levels = std::bit_width(static_cast<unsigned>(comm.size() - 1));
    const bool power = std::has_single_bit(static_cast<unsigned>(comm.size()));
    constexpr GlobalIndex n_rounds = 2, n_sums = n_rounds + 3;                     // 15 x 19 x 11 tiles
    const GlobalIndex law = n_sums * levels * (levels + 1) / 2 + levels + levels;  // the last: the total load
    if (power) {
      EXPECT_LE(sent.messages, law);
    } else {
      EXPECT_LE(sent.messages, law + n_sums * levels + 1);
    }
    EXPECT_GE(sent.messages, comm.size() == 1 ? 0 : levels);
    EXPECT_LE(sent.bytes, sent.messages * 16'384) << "histograms of 12 kB, or tiles";
  });
}

// Two clumps of 12 x 12 x 12 tiles at the ends of a grid of 68 million tiles.
TEST_F(RankNumbers, MemoryIsThatOfTilesAndCutsNotOfTheGrid) {
  const GridGeometry grid = grid_of_cells({400'000, 100, 100});
  std::vector<TileRecord> all;
  for (int n = 0; n < 2 * 12 * 12 * 12; ++n)
    all.push_back({{n % 12 + (n < 12 * 12 * 12 ? 0 : 99'980), n / 12 % 12, n / 144 % 12}, 0, 1000 + n % 7, 500});
  for_each_number([&](const Comm& comm) {
    std::vector<TileRecord> records;
    for (std::size_t n = 0; n < all.size(); ++n)
      if (static_cast<int>(n % static_cast<std::size_t>(comm.size())) == comm.rank()) records.push_back(all[n]);
    const std::size_t before = most_bytes = n_bytes;
    SentMessages sent;
    const CutTree tree = bisected_together(comm, grid, Cutting::planes, records, {}, sent);
    const std::size_t used = most_bytes - before;
    const auto n_ranks = static_cast<std::size_t>(comm.size());
    // Of records those kept, those given and those before, each in a vector that grows by doubling; histograms of 12 kB with those
    // of the partner; cuts as they come, in a vector that grows, and in the tree.
    EXPECT_LE(used, 6 * sizeof(TileRecord) * (all.size() / n_ranks + 64) + 3 * 12'288 + 4 * 8 * n_ranks + 1024);
    const std::vector<TileRecord> mine = std::move(records);
    for (const TileRecord& record : mine) EXPECT_EQ(tree.owner(record.at), comm.rank());
    EXPECT_LE(mine.size(), 2 * all.size() / n_ranks + 1);
  });
}

// Two tiles far apart and a row of them in a grid of 68 million: boxes take a number for each layer and column of the axis that is cut.
TEST_F(RankNumbers, MemoryForBoxesIsThatOfLayersNotOfTheGrid) {
  const GridGeometry grid = grid_of_cells({400'000, 100, 100});
  for_each_number([&](const Comm& comm) {
    if (comm.size() > 8) return;  // as long as it is slow: a sum of all layers for each trial
    TileCensus census;
    for (int n = comm.rank(); n < 3000; n += comm.size()) {
      census.tile.push_back(grid.tile_index({n < 2 ? 99'990 * n : 500 + n, n % 20, n / 20 % 20}));
      census.count.push_back(1000 + n % 7);
      census.cells.push_back(1);
    }
    const CostModel cost;
    const std::size_t before = most_bytes = n_bytes;
    const auto partition = make_partitioner(comm, {PartitionMethod::ranges})->propose(comm, {grid, census, cost}).partition;
    const std::size_t used = most_bytes - before;
    ASSERT_TRUE(partition && partition->boxes);
    EXPECT_LT(partition->boxes->imbalance, 1.3);
    const auto n_ranks = static_cast<std::size_t>(comm.size()), n_layers = static_cast<std::size_t>(grid.n_tiles(0));
    // Layers that nothing cuts, those of one axis with those of half as many columns as ranks, parts of layers, the map and the boxes.
    EXPECT_LE(used, n_layers * (8 + 8 * std::max<std::size_t>(1, n_ranks / 2) + 4 + 4 + 4 + 8) + 200 * 3000);
  });
}

TEST_F(RankNumbers, CensusesAreMergedByTile) {
  const GridGeometry grid = grid_of_cells({60, 76, 44});
  for_each_number([&](const Comm& comm) {
    const TileMap scattered = scattered_map(grid, comm.size());
    for (const TileMap* present : {static_cast<const TileMap*>(nullptr), &scattered}) {
      TileCensus local;
      local.n_materials = 2;
      std::mt19937 random(static_cast<unsigned>(comm.rank()));
      for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) {
        if (random() % 3 != 0) continue;
        local.tile.push_back(tile);
        local.cells.push_back(std::uint64_t{1} << random() % 64);
        local.count.push_back(random() % 5);
        local.count.push_back(local.count.back() == 0 ? 1 : random() % 7);
      }
      if (!local.tile.empty()) {  // the first tile once more, at the end
        local.tile.push_back(local.tile.front());
        local.cells.push_back(std::uint64_t{1} << random() % 64);
        for (std::size_t m = 0; m < 2; ++m) local.count.push_back(1);
      }
      SentMessages sent;
      const TileCensus merged = merged_census(comm, local, owners_or_hash(present, comm.size()), sent);
      EXPECT_LE(sent.messages, 3 * std::bit_width(static_cast<unsigned>(comm.size())) + 2);
      // Against tables of all tiles.
      std::vector<GlobalIndex> count(2 * static_cast<std::size_t>(grid.n_tiles()), 0), found = count;
      std::vector<std::uint64_t> cells(static_cast<std::size_t>(grid.n_tiles()), 0), found_cells = cells;
      const auto add = [](const TileCensus& census, auto& counts, auto& masks) {
        for (std::size_t t = 0; t < census.size(); ++t)
          for (std::size_t m = 0; m < 2; ++m) {
            counts[2 * static_cast<std::size_t>(census.tile[t]) + m] += census.count[2 * t + m];
            masks[static_cast<std::size_t>(census.tile[t])] |= census.cells[t];
          }
      };
      add(local, count, cells);
      add(merged, found, found_cells);
      std::vector<GlobalIndex> n_holders(static_cast<std::size_t>(grid.n_tiles()), 0);
      for (const TileIndex tile : merged.tile) ++n_holders[static_cast<std::size_t>(tile)];
      const auto sum = [&](auto& values, MPI_Datatype type, MPI_Op op) {
        BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), type, op, comm.get()));
      };
      sum(count, MPI_INT64_T, MPI_SUM), sum(found, MPI_INT64_T, MPI_SUM), sum(n_holders, MPI_INT64_T, MPI_SUM);
      sum(cells, MPI_UINT64_T, MPI_BOR), sum(found_cells, MPI_UINT64_T, MPI_BOR);
      EXPECT_EQ(found, count);
      EXPECT_EQ(found_cells, cells);
      EXPECT_LE(*std::max_element(n_holders.begin(), n_holders.end()), 1);
      EXPECT_TRUE(std::is_sorted(merged.tile.begin(), merged.tile.end()));
      if (!present) continue;
      for (const TileIndex tile : merged.tile) EXPECT_EQ(scattered.owner(tile), comm.rank());
    }
  });
}

}  // namespace
}  // namespace bulkley::bisection_mpi_test
