#include "grid/tile_map.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace bulkley::tile_map_test {
namespace {

TileMap scattered(const GridGeometry& grid, int n_ranks) {
  std::vector<std::int32_t> owners;
  for (TileIndex tile = 0; tile < grid.n_tiles(); ++tile) owners.push_back(tile * 7919 % 101 % n_ranks);
  return {n_ranks, std::move(owners)};
}

TEST(TileMapTest, AnswersWhoOwnsATile) {
  const TileMap map(4, {2, 0, 2, 3, 0, 2});
  EXPECT_EQ(map.n_ranks(), 4);
  EXPECT_EQ(map.n_tiles(), 6);
  EXPECT_EQ(map.owner(0), 2);
  EXPECT_EQ(map.owner(4), 0);
  EXPECT_GE(map.memory(), 1u);
  EXPECT_EQ(TileMap{}.n_tiles(), 0);
  EXPECT_EQ(TileMap{}.n_ranks(), 1);
}

TEST(TileMapTest, EqualMapsHaveEqualFingerprintsAndDifferentOnesDoNot) {
  const std::vector<std::int32_t> owners{2, 0, 2, 3, 0, 2};
  const TileMap map(4, owners);
  EXPECT_EQ(map, TileMap(4, owners));
  EXPECT_EQ(map.fingerprint(), TileMap(4, owners).fingerprint());
  std::vector<TileMap> others{TileMap(5, owners), TileMap(4, {2, 0, 2, 3, 0}), TileMap(4, {2, 0, 2, 3, 0, 2, 0}),
                              TileMap(4, {0, 2, 2, 3, 0, 2})};
  for (std::size_t tile = 0; tile < owners.size(); ++tile) {
    std::vector<std::int32_t> changed = owners;
    changed[tile] = 1;
    others.emplace_back(4, changed);
  }
  for (const TileMap& other : others) {
    EXPECT_NE(map, other);
    EXPECT_NE(map.fingerprint(), other.fingerprint());
  }
}

TEST(TileMapTest, IsTheSameAfterATransport) {
  const TileMap map(4, {2, 0, 2, 3, 0, 2});
  EXPECT_EQ(TileMap::unpack(4, TileMap(map).pack()), map);
}

// Boxes of tiles: 3 x 2 x 4 tiles for 2 x 1 x 2 ranks, z fastest.
TEST(TileMapTest, OfBoxesIsTheMapOfItsTiles) {
  const BoxOwners boxes{4, {{{0, 2, 2}, {0, 0}, {0, 0, 0, 1}}}};
  std::vector<std::int32_t> owners;
  for (const int x : boxes.of[0])
    for (const int y : boxes.of[1])
      for (const int z : boxes.of[2]) owners.push_back(x + y + z);
  const TileMap map(boxes), table(4, owners);
  EXPECT_EQ(map.n_ranks(), 4);
  EXPECT_EQ(map.n_tiles(), 24);
  EXPECT_EQ(map, table);
  EXPECT_EQ(table, map);
  for (TileIndex tile = 0; tile < map.n_tiles(); ++tile) EXPECT_EQ(map.owner(tile), owners[static_cast<std::size_t>(tile)]);
  EXPECT_EQ(map.memory(), 9 * sizeof(std::int32_t));
  EXPECT_EQ(TileMap::unpack(4, TileMap(map).pack()), map);
  EXPECT_EQ(TileMap::unpack(4, TileMap(map).pack()).fingerprint(), map.fingerprint());
  BoxOwners other = boxes;
  other.of[2][2] = 1;
  EXPECT_NE(TileMap(other), map);
  EXPECT_NE(TileMap(other).fingerprint(), map.fingerprint());
}

// Where the tiles of the two nodes have different owners.
TEST(NodeOwnerTest, ANodeBehindAWallAndItsImageHaveOneOwner) {
  for (int n_cells = 5; n_cells <= 12; ++n_cells) {
    GridGeometry geometry;
    geometry.cell_size = 0.1;
    geometry.n_cells = {n_cells, n_cells, n_cells};
    const TileMap map = scattered(geometry, 5);
    const NodeOwner owner(geometry, map);
    for (int axis = 0; axis < 3; ++axis)
      for (int n = 0; n < n_cells; ++n) {
        Int3 behind{n, n, n}, front{n, n, n};
        for (const auto& [b, f] : {std::pair{n_cells + 2, n_cells}, std::pair{0, 2}}) {
          behind[axis] = b / 4, front[axis] = f / 4;
          for (int other = 0; other < 3; ++other)
            if (other != axis) behind[other] = front[other] = n / 4;
          EXPECT_EQ(owner(behind), owner(front)) << n_cells << " cells, axis " << axis;
        }
      }
  }
}

}  // namespace
}  // namespace bulkley::tile_map_test
