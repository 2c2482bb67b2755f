#include "kernel/cells.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <string>

namespace bulkley::cells_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

GridGeometry box(SplineOrder order = SplineOrder::quadratic, bool periodic = false) {
  return {.lower = Vec3(-0.3, 0.2, 0.7),
          .cell_size = 0.1,
          .n_cells = {8, 12, 4},
          .periodic = {periodic, periodic, periodic},
          .order = order};
}

std::vector<TileIndex> all_tiles(const GridGeometry& grid) {
  std::vector<TileIndex> tiles(static_cast<std::size_t>(grid.n_tiles()));
  std::iota(tiles.begin(), tiles.end(), 0);
  return tiles;
}

Faces all(FaceKind kind) {
  Faces faces;
  for (Face& face : faces) face.kind = kind;
  return faces;
}

ParticleSet particles_at(const std::vector<Vec3>& positions) {
  ParticleSet set;
  set.resize(static_cast<LocalIndex>(positions.size()));
  for (std::size_t p = 0; p < positions.size(); ++p) {
    set.set_vector(Field::position, static_cast<LocalIndex>(p), positions[p]);
    set.id()[p] = 100 + static_cast<GlobalIndex>(p);
  }
  return set;
}

std::vector<Vec3> random_positions(const GridGeometry& grid, int count) {
  std::mt19937 generator(31);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Vec3> result;
  for (int n = 0; n < count; ++n) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = grid.lower[a] + uniform(generator) * (grid.upper()[a] - grid.lower[a]);
    result.push_back(x);
  }
  // Corners and faces; where the axis is periodic its upper end is not inside.
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = corner >> a & 1 ? grid.upper()[a] : grid.lower[a];
    if (!grid.periodic[0] || corner == 0) result.push_back(x);
  }
  return result;
}

// The cell that a base node has in a pool, from the definition of CellMap.
LocalIndex expected_cell(const GridGeometry& grid, const PoolLayout& layout, const Vec3& x) {
  Int3 base;
  for (int a = 0; a < 3; ++a) base[a] = grid.base_node(a, x[a]);
  const int local = (base[0] % 4 * 4 + base[1] % 4) * 4 + base[2] % 4;
  const LocalIndex slot = layout.slot(grid.tile_of_node(base));
  return slot < 0 ? -1 : slot * 64 + local;
}

// --- locate ----------------------------------------------------------------------------------------------------------

TEST(Locate, EveryParticleIsInTheCellOfItsBaseNode) {
  for (const auto order : {SplineOrder::quadratic, SplineOrder::cubic})
    for (const bool periodic : {false, true}) {
      const GridGeometry grid = box(order, periodic);
      const PoolLayout layout(grid, all_tiles(grid));
      const std::vector<Vec3> positions = random_positions(grid, 1000);
      const ParticleSet set = particles_at(positions);
      CellMap map;
      std::vector<OutsideParticle> outside;
      map.reset(layout, set.size());
      locate(grid, layout, set, map, outside);
      EXPECT_TRUE(outside.empty());
      ASSERT_EQ(map.cell.size(), positions.size() + ParticleSet::padding);
      std::map<LocalIndex, LocalIndex> count;
      GlobalIndex largest = 0;
      for (std::size_t p = 0; p < positions.size(); ++p) {
        ASSERT_EQ(map.cell[p], expected_cell(grid, layout, positions[p]));
        largest = std::max<GlobalIndex>(largest, ++count[map.cell[p]]);
      }
      EXPECT_EQ(map.largest_count(), largest);
      ASSERT_EQ(map.count.size(), layout.tiles().size() * 64);
      for (std::size_t cell = 0; cell < map.count.size(); ++cell)
        ASSERT_EQ(map.count[cell], count[static_cast<LocalIndex>(cell)]);
      for (std::size_t p = positions.size(); p < map.cell.size(); ++p) EXPECT_EQ(map.cell[p], 0);
    }
}

TEST(Locate, ParticlesOfOtherTilesAreStrays) {
  const GridGeometry grid = box();
  std::vector<TileIndex> tiles;
  for (const TileIndex tile : all_tiles(grid))
    if (tile % 3 == 1) tiles.push_back(tile);
  const PoolLayout layout(grid, tiles);
  const std::vector<Vec3> positions = random_positions(grid, 1000);
  const ParticleSet set = particles_at(positions);
  CellMap map;
  std::vector<OutsideParticle> outside;
  map.reset(layout, set.size());
  locate(grid, layout, set, map, outside);
  std::size_t next = 0;
  LocalIndex n_inside = 0;
  for (std::size_t p = 0; p < positions.size(); ++p) {
    const LocalIndex cell = expected_cell(grid, layout, positions[p]);
    if (cell >= 0) {
      ++n_inside;
      EXPECT_EQ(map.cell[p], cell);
      continue;
    }
    EXPECT_EQ(map.cell[p], 0);
    ASSERT_LT(next, outside.size());
    EXPECT_EQ(outside[next].particle, static_cast<LocalIndex>(p));
    EXPECT_EQ(outside[next].tile, grid.tile_of(positions[p]));
    ++next;
  }
  EXPECT_EQ(next, outside.size());
  EXPECT_EQ(std::accumulate(map.count.begin(), map.count.end(), 0), n_inside);
}

TEST(Locate, WithoutTilesAllAreStraysAndWithoutParticlesThereAreNone) {
  const GridGeometry grid = box();
  CellMap map;
  std::vector<OutsideParticle> outside;
  const PoolLayout no_tiles(grid, {}), layout(grid, all_tiles(grid));
  map.reset(no_tiles, 18);
  locate(grid, no_tiles, particles_at(random_positions(grid, 10)), map, outside);
  EXPECT_EQ(outside.size(), 18u);
  EXPECT_EQ(map.largest_count(), 0);
  outside.clear();
  map.reset(layout, 0);
  locate(grid, layout, particles_at({}), map, outside);
  EXPECT_TRUE(outside.empty());
  EXPECT_EQ(map.largest_count(), 0);
}

// In blocks, and with particles that arrive after the others have been counted.
TEST(Locate, BlocksTogetherFindWhatOnePassFinds) {
  const GridGeometry grid = box();
  std::vector<TileIndex> tiles = all_tiles(grid);
  tiles.erase(tiles.begin() + 5);
  const PoolLayout layout(grid, tiles);
  const ParticleSet set = particles_at(random_positions(grid, 500));
  CellMap whole, parts;
  std::vector<OutsideParticle> outside, outside_of_parts;
  whole.reset(layout, set.size());
  locate(grid, layout, set, whole, outside);
  const LocalIndex block = ParticleSet::padding, n_first = 300;  // 300: not a multiple of any pack
  parts.reset(layout, n_first);
  for (LocalIndex begin = 0; begin < n_first; begin += block)
    locate(grid, layout, set, parts, outside_of_parts, {begin, std::min(begin + block, n_first)});
  parts.resize(set.size());
  locate(grid, layout, set, parts, outside_of_parts, {n_first, set.size()});
  EXPECT_EQ(parts.cell, whole.cell);
  EXPECT_EQ(parts.count, whole.count);
  EXPECT_EQ(parts.largest_count(), whole.largest_count());
  ASSERT_FALSE(outside.empty());
  ASSERT_EQ(outside_of_parts.size(), outside.size());
  for (std::size_t n = 0; n < outside.size(); ++n) EXPECT_EQ(outside_of_parts[n].particle, outside[n].particle);
}

TEST(Locate, CountsTheJumpsFromTileToTile) {
  const GridGeometry grid = box();
  const PoolLayout layout(grid, all_tiles(grid));
  const Vec3 one = grid.lower + Vec3(0.15, 0.15, 0.15), other = grid.lower + Vec3(0.55, 0.15, 0.15);
  ParticleSet set = particles_at({one, one, other, other, other, one, other, other, other, other, other, other, one});
  CellMap map;
  std::vector<OutsideParticle> outside;
  map.reset(layout, set.size());
  locate(grid, layout, set, map, outside);
  EXPECT_EQ(map.n_jumps, 5);  // the first particle's tile, then four changes
  sort_particles(set, map);
  map.reset(layout, set.size());
  locate(grid, layout, set, map, outside);
  EXPECT_EQ(map.n_jumps, 2);
}

// --- tiles in reach --------------------------------------------------------------------------------------------------

// Every base node within one cell of a particle's, tried one by one.
std::vector<TileIndex> tiles_within_one_cell(const GridGeometry& grid, const ParticleSet& set) {
  std::vector<TileIndex> tiles;
  for (LocalIndex p = 0; p < set.size(); ++p)
    for (int d = 0; d < 27; ++d) {
      Int3 node{};
      bool exists = true;
      for (int a = 0; a < 3; ++a) {
        const int n = grid.n_nodes(a);
        node[a] = grid.base_node(a, set.vector(Field::position, p)[a]) + (a == 0 ? d / 9 : a == 1 ? d / 3 % 3 : d % 3) - 1;
        if (grid.periodic[a]) node[a] = (node[a] + n) % n;
        exists = exists && node[a] >= 0 && node[a] < n;
      }
      if (exists) tiles.push_back(grid.tile_of_node(node));
    }
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

TEST(TilesInReach, AreThoseOfAllCellsWithinOneStep) {
  for (const bool periodic : {false, true}) {
    GridGeometry grid = box(SplineOrder::quadratic, periodic);
    grid.n_cells = {16, 12, 20};
    const std::vector<Vec3> positions = random_positions(grid, 60);
    for (const Vec3& x : positions) {
      const ParticleSet one = particles_at({x});
      EXPECT_EQ(tiles_in_reach(grid, take_census(grid, one, 1)), tiles_within_one_cell(grid, one));
    }
    const ParticleSet all = particles_at(positions);
    EXPECT_EQ(tiles_in_reach(grid, take_census(grid, all, 1)), tiles_within_one_cell(grid, all));
    EXPECT_TRUE(tiles_in_reach(grid, take_census(grid, particles_at({}), 1)).empty());
  }
}

// --- sort ------------------------------------------------------------------------------------------------------------

TEST(SortParticles, OrdersByCellAndKeepsTheOrderWithinOne) {
  const GridGeometry grid = box();
  const PoolLayout layout(grid, all_tiles(grid));
  ParticleSet set = particles_at(random_positions(grid, 2000));
  CellMap map;
  std::vector<OutsideParticle> outside;
  map.reset(layout, set.size());
  locate(grid, layout, set, map, outside);
  std::vector<std::pair<LocalIndex, GlobalIndex>> expected;
  std::map<GlobalIndex, Vec3> position;
  for (LocalIndex p = 0; p < set.size(); ++p) {
    expected.emplace_back(map.cell[p], set.id()[p]);
    position[set.id()[p]] = set.vector(Field::position, p);
  }
  std::sort(expected.begin(), expected.end());  // ids ascend with the original order
  const std::vector<LocalIndex> count = map.count;
  sort_particles(set, map);
  for (LocalIndex p = 0; p < set.size(); ++p) {
    ASSERT_EQ(map.cell[p], expected[static_cast<std::size_t>(p)].first);
    ASSERT_EQ(set.id()[p], expected[static_cast<std::size_t>(p)].second);
    ASSERT_EQ(set.vector(Field::position, p), position[set.id()[p]]);
  }
  EXPECT_EQ(map.count, count);

  ParticleSet none = particles_at({});
  map.reset(layout, 0);
  locate(grid, layout, none, map, outside);
  sort_particles(none, map);
  EXPECT_EQ(none.size(), 0);
}

// --- confine ---------------------------------------------------------------------------------------------------------

struct Confined {
  std::vector<Vec3> positions;
  std::vector<LocalIndex> removed;
  StepBounds bounds;
};

Confined confined(const GridGeometry& grid, const Faces& faces, const std::vector<Vec3>& positions) {
  ParticleSet set = particles_at(positions);
  Confined result;
  confine(grid, faces, set, result.removed, result.bounds);
  for (LocalIndex p = 0; p < set.size(); ++p) result.positions.push_back(set.vector(Field::position, p));
  return result;
}

TEST(Confine, InsideAndOnTheFacesNothingChanges) {
  const GridGeometry grid = box();
  for (const FaceKind kind : {FaceKind::sticky, FaceKind::slip, FaceKind::separating, FaceKind::outflow, FaceKind::open}) {
    const std::vector<Vec3> positions = random_positions(grid, 100);
    const Confined result = confined(grid, all(kind), positions);
    EXPECT_EQ(result.positions, positions);
    EXPECT_TRUE(result.removed.empty());
    EXPECT_FALSE(result.bounds.failed());
  }
}

TEST(Confine, WallsTakeBackWhatCrossedThemByLessThanHalfACell) {
  const GridGeometry grid = box();
  const Vec3 middle(0.1, 0.8, 0.9), lower = grid.lower, upper = grid.upper();
  for (const FaceKind kind : {FaceKind::sticky, FaceKind::slip, FaceKind::separating})
    for (int a = 0; a < 3; ++a)
      for (const double depth : {1e-17, 1e-9, 0.049}) {
        Vec3 below = middle, above = middle, below_wall = middle, above_wall = middle;
        below[a] = std::min(lower[a] - depth, std::nextafter(lower[a], -infinity));
        above[a] = std::max(upper[a] + depth, std::nextafter(upper[a], infinity));
        below_wall[a] = lower[a];
        above_wall[a] = upper[a];
        const Confined result = confined(grid, all(kind), {below, above});
        EXPECT_EQ(result.positions[0], below_wall);
        EXPECT_EQ(result.positions[1], above_wall);
        EXPECT_FALSE(result.bounds.failed());
      }
  // Three walls at once.
  const Confined corner = confined(grid, all(FaceKind::slip), {lower - 0.03 * Vec3::Ones(), upper + 0.03 * Vec3::Ones()});
  EXPECT_EQ(corner.positions[0], lower);
  EXPECT_EQ(corner.positions[1], upper);
}

TEST(Confine, FartherOutOrThroughAnOpenFaceIsAnEscape) {
  const GridGeometry grid = box();
  const Vec3 middle(0.1, 0.8, 0.9);
  std::vector<Vec3> far, hair;
  for (int a = 0; a < 3; ++a) {
    far.push_back(middle);
    far.back()[a] = grid.lower[a] - 0.051;
    far.push_back(middle);
    far.back()[a] = grid.upper()[a] + 0.051;
    hair.push_back(middle);
    hair.back()[a] = std::nextafter(grid.lower[a], -infinity);
    hair.push_back(middle);
    hair.back()[a] = std::nextafter(grid.upper()[a], infinity);
  }
  for (const auto& [kind, positions] : {std::pair{FaceKind::sticky, far}, {FaceKind::slip, far}, {FaceKind::open, hair}}) {
    const Confined result = confined(grid, all(kind), positions);
    EXPECT_EQ(result.positions, positions) << "they stay for the report";
    EXPECT_EQ(result.bounds.failures.n_escaped, 6);
    EXPECT_EQ(result.bounds.failures.failed_id, 100);
    EXPECT_TRUE(result.removed.empty());
  }
}

TEST(Confine, OutflowsRemoveInAscendingOrder) {
  const GridGeometry grid = box();
  Faces faces = all(FaceKind::sticky);
  faces[1].kind = FaceKind::outflow;
  const Vec3 middle(0.1, 0.8, 0.9);
  Vec3 out = middle, hair = middle, on = middle, wall = middle;
  out[0] = grid.upper()[0] + 10.0;
  hair[0] = std::nextafter(grid.upper()[0], infinity);
  on[0] = grid.upper()[0];
  wall[0] = grid.lower[0] - 0.01;
  Vec3 both = out;  // through the outflow and, a little, through a wall
  both[2] = grid.lower[2] - 0.01;
  Vec3 lost = out;  // through the outflow and far through a wall
  lost[2] = grid.lower[2] - 1.0;
  const Confined result = confined(grid, faces, {middle, out, on, hair, wall, both});
  EXPECT_EQ(result.removed, (std::vector<LocalIndex>{1, 3, 5}));
  EXPECT_FALSE(result.bounds.failed());
  EXPECT_EQ(result.positions[2], on);
  EXPECT_EQ(result.positions[4][0], grid.lower[0]);
  EXPECT_EQ(confined(grid, faces, {lost}).bounds.failures.n_escaped, 1);
}

TEST(Confine, PeriodicAxesWrap) {
  GridGeometry grid = box(SplineOrder::cubic, true);
  const Faces faces = all(FaceKind::periodic);
  const Vec3 length = grid.upper() - grid.lower;
  for (int a = 0; a < 3; ++a)
    for (const double shift : {0.01, 0.05, 0.3}) {
      Vec3 below = grid.lower + 0.2 * length, above = below;
      below[a] = grid.lower[a] - shift;
      above[a] = grid.upper()[a] + shift;
      const Confined result = confined(grid, faces, {below, above});
      EXPECT_NEAR(result.positions[0][a], grid.upper()[a] - shift, 1e-15);
      EXPECT_NEAR(result.positions[1][a], grid.lower[a] + shift, 1e-15);
      EXPECT_FALSE(result.bounds.failed());
    }
}

// The edges to the last bit, for many boxes: always inside afterwards, always near the edge, never an escape.
TEST(Confine, PeriodicEdgesAreHalfOpenToTheLastBit) {
  std::mt19937_64 generator(32);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int trial = 0; trial < 1000; ++trial) {
    GridGeometry grid = box(SplineOrder::quadratic, true);
    grid.cell_size = std::exp(10.0 * uniform(generator) - 8.0);
    for (int a = 0; a < 3; ++a) grid.lower[a] = 10.0 * (uniform(generator) - 0.5);
    const Vec3 lower = grid.lower, upper = grid.upper();
    std::vector<Vec3> positions;
    for (int a = 0; a < 3; ++a)
      for (const double x : {lower[a], std::nextafter(lower[a], -infinity), lower[a] - 1e-300, lower[a] - 1e-14, upper[a],
                             std::nextafter(upper[a], infinity), std::nextafter(upper[a], -infinity), upper[a] + 1e-14}) {
        positions.push_back(lower);
        positions.back()[a] = x;
      }
    const Confined result = confined(grid, all(FaceKind::periodic), positions);
    ASSERT_FALSE(result.bounds.failed());
    for (std::size_t p = 0; p < positions.size(); ++p)
      for (int a = 0; a < 3; ++a) {
        const double found = result.positions[p][a];
        ASSERT_TRUE(found >= lower[a] && found < upper[a]) << positions[p][a];
        ASSERT_LE(std::min(found - lower[a], upper[a] - found), 1e-13);
        const int base = grid.base_node(a, found);
        ASSERT_TRUE(base >= 0 && base < grid.n_cells[a]);
      }
  }
}

TEST(Confine, MoreThanOnePeriodOutsideIsAnEscape) {
  const GridGeometry grid = box(SplineOrder::quadratic, true);
  const Vec3 length = grid.upper() - grid.lower;
  const std::vector<Vec3> far = {grid.lower - 1.2 * length, grid.upper() + 1.2 * length,
                                 Vec3(grid.upper()[0] + 1e6, 0.5, 0.8)};
  const Confined result = confined(grid, all(FaceKind::periodic), far);
  EXPECT_EQ(result.bounds.failures.n_escaped, 3);
  EXPECT_EQ(result.positions, far);
}

TEST(Confine, PositionsThatAreNotFiniteAreCountedAsSuch) {
  for (const bool periodic : {false, true}) {
    const GridGeometry grid = box(SplineOrder::quadratic, periodic);
    const Vec3 middle(0.1, 0.8, 0.9);
    const Confined result = confined(grid, all(periodic ? FaceKind::periodic : FaceKind::outflow),
                                     {middle, Vec3(nan, 0.8, 0.9), Vec3(0.1, infinity, 0.9), Vec3(0.1, 0.8, -infinity)});
    EXPECT_EQ(result.bounds.failures.n_not_finite, 3);
    EXPECT_EQ(result.bounds.failures.n_escaped, 0);
    EXPECT_EQ(result.bounds.failures.failed_id, 101);
    EXPECT_TRUE(result.removed.empty());
  }
}

}  // namespace
}  // namespace bulkley::cells_test
