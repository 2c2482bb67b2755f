#include "bulkley/kernel/cells.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

bool is_wall(FaceKind kind) { return kind == FaceKind::sticky || kind == FaceKind::slip || kind == FaceKind::separating; }

enum class Verdict { inside, removed, escaped };

// One coordinate of a particle that is not within [lower, upper) of its axis.
Verdict confine_coordinate(const GridGeometry& grid, const Faces& faces, int axis, double lower, double upper, double& x) {
  if (grid.periodic[axis]) {
    const double wrapped = x < lower ? x + (upper - lower) : x - (upper - lower);
    const double hair = 1e-6 * grid.cell_size;  // rounding may leave it so far outside; both ends are the same place
    if (wrapped < lower - hair || wrapped > upper + hair) return Verdict::escaped;
    x = wrapped < lower || wrapped >= upper ? lower : wrapped;
    return Verdict::inside;
  }
  const bool below = x < lower;
  const double face = below ? lower : upper;
  const FaceKind kind = faces[2 * axis + (below ? 0 : 1)].kind;
  if (kind == FaceKind::outflow) return Verdict::removed;
  if (is_wall(kind) && std::abs(x - face) <= 0.5 * grid.cell_size) {
    x = face;
    return Verdict::inside;
  }
  return Verdict::escaped;
}

}  // namespace

void confine(const GridGeometry& grid, const Faces& faces, ParticleSet& particles, std::vector<LocalIndex>& removed,
             StepBounds& bounds) {
  double* x[3] = {particles.real(Field::position, 0), particles.real(Field::position, 1),
                  particles.real(Field::position, 2)};
  const Vec3 lower = grid.lower, upper = grid.upper();
  const LocalIndex n = particles.size();
  for (LocalIndex p = 0; p < n; ++p) {
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      // Comparisons that are false for NaN; a particle exactly on a wall's face is inside.
      const bool fine = x[a][p] >= lower[a] && (grid.periodic[a] ? x[a][p] < upper[a] : x[a][p] <= upper[a]);
      inside = inside && fine;
    }
    if (inside) continue;

    const GlobalIndex id = particles.id()[p];
    if (!std::isfinite(x[0][p]) || !std::isfinite(x[1][p]) || !std::isfinite(x[2][p])) {
      ++bounds.n_not_finite;
      bounds.failed_id = std::min(bounds.failed_id, id);
      continue;
    }
    Verdict verdict = Verdict::inside;
    for (int a = 0; a < 3; ++a) {
      const bool fine = x[a][p] >= lower[a] && (grid.periodic[a] ? x[a][p] < upper[a] : x[a][p] <= upper[a]);
      if (!fine) verdict = std::max(verdict, confine_coordinate(grid, faces, a, lower[a], upper[a], x[a][p]));
    }
    if (verdict == Verdict::removed) removed.push_back(p);
    if (verdict == Verdict::escaped) {
      ++bounds.n_escaped;
      bounds.failed_id = std::min(bounds.failed_id, id);
    }
  }
}

void locate(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, CellMap& map,
            std::vector<Stray>& strays, StepBounds& bounds) {
  const LocalIndex n = particles.size();
  map.cell.resize(static_cast<std::size_t>(n) + ParticleSet::padding);
  map.count.assign(layout.tiles().size() * tile_nodes, 0);
  const double* x[3] = {particles.real(Field::position, 0), particles.real(Field::position, 1),
                        particles.real(Field::position, 2)};
  // The last tile that was looked up: consecutive particles mostly share it.
  Int3 last{-1, -1, -1};
  LocalIndex slot = -1;
  TileIndex tile = -1;
  for (LocalIndex p = 0; p < n; ++p) {
    Int3 base;
    for (int a = 0; a < 3; ++a) base[a] = grid.base_node(a, x[a][p]);
    const Int3 t{base[0] / tile_width, base[1] / tile_width, base[2] / tile_width};
    if (t != last) {
      last = t;
      tile = grid.tile_index(t);
      slot = layout.slot(tile);
    }
    if (slot < 0) {
      map.cell[p] = 0;
      strays.push_back({p, tile});
      continue;
    }
    const int local = ((base[0] % tile_width) * tile_width + base[1] % tile_width) * tile_width + base[2] % tile_width;
    const LocalIndex cell = slot * tile_nodes + local;
    map.cell[p] = cell;
    bounds.cell_count = std::max<GlobalIndex>(bounds.cell_count, ++map.count[cell]);
  }
  std::fill(map.cell.begin() + n, map.cell.end(), 0);
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
