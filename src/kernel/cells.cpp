#include "kernel/cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "bulkley/base/error.hpp"
#include "grid/slot_table.hpp"
#include "kernel/batch.hpp"

namespace bulkley {

namespace {

enum class Verdict { inside, removed, escaped };

// One coordinate of a particle that is not within [lower, upper) of its axis.
Verdict confine_coordinate(const GridGeometry& grid, const Faces& faces, int axis, double lower, double upper, double& x) {
  if (grid.periodic[axis]) {
    const double wrapped = x < lower ? x + (upper - lower) : x - (upper - lower);
    const double tolerance = 1e-6 * grid.cell_size;  // rounding may leave it so far outside; both ends are the same place
    if (wrapped < lower - tolerance || wrapped > upper + tolerance) return Verdict::escaped;
    x = wrapped < lower || wrapped >= upper ? lower : wrapped;
    return Verdict::inside;
  }
  const bool below = x < lower;
  const double face = below ? lower : upper;
  const Crossing crossing = behaviour(faces[2 * axis + (below ? 0 : 1)].kind).crossing;
  if (crossing == Crossing::removed) return Verdict::removed;
  if (crossing == Crossing::held && std::abs(x - face) <= 0.5 * grid.cell_size) {
    x = face;
    return Verdict::inside;
  }
  return Verdict::escaped;
}

// Whether a coordinate lies in the domain. Comparisons that are false for NaN; a particle exactly on a wall's face is
// inside.
template <class Real>
Mask<Real> within(const GridGeometry& grid, int axis, double lower, double upper, Real x) {
  const Mask<Real> below = grid.periodic[axis] ? x < broadcast<Real>(upper) : x <= broadcast<Real>(upper);
  return (x >= broadcast<Real>(lower)) & below;
}

// What `confine` does to one particle that is not within the domain.
void confine_particle(const GridGeometry& grid, const Faces& faces, LocalIndex p, double* const (&x)[3], GlobalIndex id,
                      std::vector<LocalIndex>& removed, StepBounds& bounds) {
  if (!std::isfinite(x[0][p]) || !std::isfinite(x[1][p]) || !std::isfinite(x[2][p])) {
    ++bounds.failures.n_not_finite;
    bounds.failures.failed_id.include(id);
    return;
  }
  const Vec3 lower = grid.lower, upper = grid.upper();
  Verdict verdict = Verdict::inside;
  for (int a = 0; a < 3; ++a)
    if (!within(grid, a, lower[a], upper[a], x[a][p]))
      verdict = std::max(verdict, confine_coordinate(grid, faces, a, lower[a], upper[a], x[a][p]));
  if (verdict == Verdict::removed) removed.push_back(p);
  if (verdict == Verdict::escaped) {
    ++bounds.failures.n_escaped;
    bounds.failures.failed_id.include(id);
  }
}

// Tile, and base node within the tile, of n_lanes particles. All numbers are small integers, exact in double.
struct Place {
  Pack tile;
  Pack local;
};

void store_integers(Pack values, std::int32_t (&to)[n_lanes]) {
  using Integers [[gnu::vector_size(n_lanes * 4)]] = std::int32_t;
  const Integers integers = __builtin_convertvector(values, Integers);
  std::memcpy(to, &integers, sizeof to);
}

inline Place place_of(const CellFrame& frame, const Int3& n_tiles, const FieldColumns<3>& position, LocalIndex first) {
  Place place{};
#pragma GCC unroll 3
  for (int a = 0; a < 3; ++a) {
    const Pack base = frame.base_node(a, position(first, a));
    const Pack tile = round_down(base * (1.0 / tile_width));
    place.tile = place.tile * static_cast<double>(n_tiles[a]) + tile;
    place.local = place.local * static_cast<double>(tile_width) + (base - tile * static_cast<double>(tile_width));
  }
  return place;
}

}  // namespace

[[gnu::flatten]] void confine(const GridGeometry& grid, const Faces& faces, ParticleSet& particles,
                              std::vector<LocalIndex>& removed, StepBounds& bounds, ParticleBlock block) {
  double* const x[3] = {particles.real(Field::position, 0), particles.real(Field::position, 1),
                        particles.real(Field::position, 2)};
  const Vec3 lower = grid.lower, upper = grid.upper();
  const LocalIndex end = std::min(block.end, particles.size());
  for (LocalIndex first = block.begin; first < end; first += n_lanes) {
    PackMask inside = PackMask{} - 1;
    for (int a = 0; a < 3; ++a) inside &= within(grid, a, lower[a], upper[a], load(x[a] + first));
    if (!any(~inside)) continue;
    for (int lane = 0; lane < std::min<LocalIndex>(n_lanes, end - first); ++lane)
      if (!inside[lane]) confine_particle(grid, faces, first + lane, x, particles.id()[first + lane], removed, bounds);
  }
}

void CellMap::reset(const PoolLayout& layout, LocalIndex n_particles) {
  resize(n_particles);
  count.assign(layout.tiles().size() * tile_nodes, 0);
  n_jumps = 0;
}

void CellMap::resize(LocalIndex n_particles) {
  const auto size = static_cast<std::size_t>(n_particles) + ParticleSet::padding;
  if (size > cell.capacity()) cell.reserve(size + size / 8);  // as much as columns; a vector by itself would double
  cell.resize(size);
  std::fill(cell.begin() + n_particles, cell.end(), 0);
}

LocalIndex CellMap::largest_count() const { return count.empty() ? 0 : *std::max_element(count.begin(), count.end()); }

[[gnu::flatten]] void locate(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, CellMap& map,
                             std::vector<OutsideParticle>& outside, ParticleBlock block) {
  const CellFrame frame(grid);
  const Int3 n_tiles{grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)};
  const FieldColumns<3> position(particles, Field::position);
  LocalIndex* const cell = map.cell.data();
  LocalIndex* const count = map.count.data();
  const LocalIndex end = std::min(block.end, particles.size());
  TileIndex last_tile = -1;
  LocalIndex slot = -1, n_jumps = 0;
  for (LocalIndex first = block.begin; first < end; first += n_lanes) {
    const Place place = place_of(frame, n_tiles, position, first);
    TileIndex tile[n_lanes];
    std::int32_t local[n_lanes];
    store_integers(place.tile, tile);
    store_integers(place.local, local);
    const int n = std::min<LocalIndex>(n_lanes, end - first);
    for (int lane = 0; lane < n; ++lane) {
      if (tile[lane] != last_tile) {
        last_tile = tile[lane];
        slot = layout.slot(last_tile);
        ++n_jumps;
      }
      if (slot < 0) {
        cell[first + lane] = 0;
        outside.push_back({first + lane, last_tile});
        continue;
      }
      const LocalIndex here = slot * tile_nodes + local[lane];
      cell[first + lane] = here;
      ++count[here];
    }
  }
  map.n_jumps += n_jumps;
}

namespace {

// Calls visit(particle, tile, node in the tile) for all, in their order.
template <class Visit>
void for_each_place(const GridGeometry& grid, const ParticleSet& particles, Visit visit) {
  const CellFrame frame(grid);
  const Int3 n_tiles{grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)};
  const FieldColumns<3> position(particles, Field::position);
  for (LocalIndex first = 0; first < particles.size(); first += n_lanes) {
    const Place place = place_of(frame, n_tiles, position, first);
    TileIndex tile[n_lanes];
    std::int32_t local[n_lanes];
    store_integers(place.tile, tile);
    store_integers(place.local, local);
    for (int lane = 0; lane < std::min<LocalIndex>(n_lanes, particles.size() - first); ++lane)
      visit(first + lane, tile[lane], local[lane]);
  }
}

}  // namespace

// Neighbours in the order of particles mostly share a tile.
[[gnu::flatten]] TileCensus take_census(const GridGeometry& grid, const ParticleSet& particles, int n_materials) {
  TileCensus census;
  census.n_materials = n_materials;
  for_each_place(grid, particles, [&](LocalIndex, TileIndex tile, std::int32_t) {
    if (census.tile.empty() || census.tile.back() != tile) census.tile.push_back(tile);
  });
  std::sort(census.tile.begin(), census.tile.end());
  census.tile.erase(std::unique(census.tile.begin(), census.tile.end()), census.tile.end());
  census.cells.assign(census.size(), 0);
  census.count.assign(census.size() * static_cast<std::size_t>(n_materials), 0);
  const SlotTable slots(census.tile);
  const std::uint8_t* const material = particles.material();
  for_each_place(grid, particles, [&](LocalIndex p, TileIndex tile, std::int32_t node) {
    const auto t = static_cast<std::size_t>(slots.slot(tile));
    census.cells[t] |= std::uint64_t{1} << node;
    ++census.count[t * static_cast<std::size_t>(n_materials) + material[p]];
  });
  return census;
}

namespace {

// cells[d]: the cells of a tile from which one step may lead to its neighbour number d.
struct ReachTable {
  std::uint64_t cells[27] = {};

  ReachTable() {
    for (int d = 0; d < 27; ++d)
      for (int n = 0; n < tile_nodes; ++n) {
        const int at[3] = {n / (tile_width * tile_width), n / tile_width % tile_width, n % tile_width};
        const int step[3] = {d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1};
        bool near = true;
        for (int a = 0; a < 3; ++a) near = near && (step[a] == 0 || at[a] == (step[a] < 0 ? 0 : tile_width - 1));
        if (near) cells[d] |= std::uint64_t{1} << n;
      }
  }
};

}  // namespace

std::uint32_t reach_of(std::uint64_t cells) {
  static const ReachTable table;
  std::uint32_t reach = 0;
  for (int d = 0; d < 27; ++d) reach |= static_cast<std::uint32_t>((cells & table.cells[d]) != 0) << d;
  return reach;
}

std::vector<TileIndex> tiles_in_reach(const GridGeometry& grid, const TileCensus& census) {
  std::vector<TileIndex> tiles;
  for (std::size_t t = 0; t < census.size(); ++t)
    visit_reach(grid, grid.tile_coordinates(census.tile[t]), census.cells[t],
                [&](TileIndex there) { tiles.push_back(there); });
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

void sort_particles(ParticleSet& particles, CellMap& map) {
  const LocalIndex n = particles.size();
  BULKLEY_ASSERT(map.cell.size() >= static_cast<std::size_t>(n));
  std::vector<LocalIndex> next(map.count.size() + 1, 0);
  std::partial_sum(map.count.begin(), map.count.end(), next.begin() + 1);
  BULKLEY_ASSERT(next.back() == n);
  std::vector<LocalIndex> order(n);
  for (LocalIndex p = 0; p < n; ++p) order[next[map.cell[p]]++] = p;
  particles.reorder(order);
  LocalIndex p = 0;
  for (std::size_t cell = 0; cell < map.count.size(); ++cell)
    for (LocalIndex k = 0; k < map.count[cell]; ++k) map.cell[p++] = static_cast<LocalIndex>(cell);
}

}  // namespace bulkley
