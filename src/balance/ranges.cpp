#include "balance/ranges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

// How cuts are found.
//
// A chain of loads is cut by bisection of the bound: for a given bound, parts are filled greedily from the left, which
// succeeds if and only if any cuts keep below the bound. The smallest bound that succeeds, to 1e-4 of the mean, is the
// largest load. A second pass with that bound from the right says how far left each cut may lie; between the two limits
// every cut goes as near as possible to where it is wanted (equal parts).
// Boxes are cuts along three axes at once, which has no such simple optimum. So each axis is cut as a chain of layers of
// tiles, where a layer counts the loads of all columns that the cuts of the other two axes make, and no column may exceed
// the bound. The axes take turns until none lowers the largest load of a box; then the cuts move
// towards equal parts as far as 2 % more load allow. Loads of boxes come from a summed-area table,
// eight look-ups each.
// This is done for every way to write the number of ranks as a product of three; of the results within 5 % of the smallest
// largest load the one with the least cut surface is taken. Memory: one number a tile.

namespace bulkley {

namespace {

// Sums of a load over boxes of tiles in constant time (summed-area table).
class LoadTable {
 public:
  LoadTable(const Int3& n_tiles, const std::vector<GlobalIndex>& load)
      : n_(n_tiles), sums_(static_cast<std::size_t>(n_[0] + 1) * (n_[1] + 1) * (n_[2] + 1), 0) {
    std::size_t tile = 0;
    for (int x = 0; x < n_[0]; ++x)
      for (int y = 0; y < n_[1]; ++y) {
        GlobalIndex row = 0;
        for (int z = 0; z < n_[2]; ++z) {
          row += load[tile++];
          sums_[at(x + 1, y + 1, z + 1)] =
              row + sums_[at(x, y + 1, z + 1)] + sums_[at(x + 1, y, z + 1)] - sums_[at(x, y, z + 1)];
        }
      }
  }

  const Int3& n_tiles() const { return n_; }
  GlobalIndex total() const { return sums_.back(); }

  GlobalIndex box(const Int3& a, const Int3& b) const {
    return sums_[at(b[0], b[1], b[2])] - sums_[at(a[0], b[1], b[2])] - sums_[at(b[0], a[1], b[2])] -
           sums_[at(b[0], b[1], a[2])] + sums_[at(a[0], a[1], b[2])] + sums_[at(a[0], b[1], a[2])] +
           sums_[at(b[0], a[1], a[2])] - sums_[at(a[0], a[1], a[2])];
  }

 private:
  std::size_t at(int x, int y, int z) const { return (static_cast<std::size_t>(x) * (n_[1] + 1) + y) * (n_[2] + 1) + z; }
  Int3 n_;
  std::vector<GlobalIndex> sums_;
};

struct Candidate {
  Int3 n_ranks{1, 1, 1};
  std::array<Cuts, 3> cuts;
  GlobalIndex largest_load = 0;
  GlobalIndex surface = 0;  // nodes on the cut planes
};

// Loads of layers of tiles across one axis, each in the columns that the cuts of the other two axes make.
struct Layers {
  int n_layers = 0;
  int n_columns = 0;
  std::vector<GlobalIndex> load;  // [layer * n_columns + column]

  // Layers from `from` in direction `step` until some column would exceed `bound` or the next layer were `stop`;
  // returns the first layer that is not taken.
  int take(int from, int stop, int step, GlobalIndex bound) const {
    std::vector<GlobalIndex> filled(n_columns, 0);
    int layer = from;
    for (; layer != stop; layer += step)
      for (int c = 0; c < n_columns; ++c) {
        filled[c] += load[static_cast<std::size_t>(layer) * n_columns + c];
        if (filled[c] > bound) return layer;
      }
    return layer;
  }
};

// Whether n_parts runs of at least one layer exist that do not exceed `bound` in any column: filled greedily.
bool divides(const Layers& layers, int n_parts, GlobalIndex bound, Cuts& cuts) {
  cuts.assign(1, 0);
  for (int part = 1; part <= n_parts; ++part) {
    const int stop = layers.n_layers - (n_parts - part);  // a layer is left for every later part
    cuts.push_back(layers.take(cuts.back(), stop, 1, bound));
    if (cuts[part] == cuts[part - 1]) return false;
  }
  return cuts.back() == layers.n_layers;
}

// Cuts whose largest load is as small as it can be, to 1e-4 of the mean, found by bisection of that load.
Cuts smallest_load_cuts(const Layers& layers, int n_parts) {
  std::vector<GlobalIndex> totals(layers.n_columns, 0);
  for (std::size_t n = 0; n < layers.load.size(); ++n) totals[n % layers.n_columns] += layers.load[n];
  GlobalIndex high = *std::max_element(totals.begin(), totals.end());  // divides always
  GlobalIndex low = high / n_parts - 1;                                // less than the mean: divides never
  const GlobalIndex precision = std::max<GlobalIndex>(1, low / 10000);
  Cuts cuts;
  while (high - low > precision) {
    const GlobalIndex middle = low + (high - low) / 2;
    (divides(layers, n_parts, middle, cuts) ? high : low) = middle;
  }
  divides(layers, n_parts, high, cuts);
  return cuts;
}

// Cuts as near to `wanted` as they can be without exceeding `bound`. Precondition: some cuts do not exceed it.
Cuts nearest_cuts(const Layers& layers, const Cuts& wanted, GlobalIndex bound) {
  const int n_parts = static_cast<int>(wanted.size()) - 1;
  Cuts lowest(wanted.size());  // below it, the parts to the right could not hold the rest
  lowest[n_parts] = layers.n_layers;
  for (int part = n_parts - 1; part > 0; --part) lowest[part] = layers.take(lowest[part + 1] - 1, part - 1, -1, bound) + 1;
  Cuts cuts{0};
  for (int part = 1; part < n_parts; ++part) {
    const int low = std::max(lowest[part], cuts.back() + 1);
    const int high = layers.take(cuts.back(), layers.n_layers - (n_parts - part), 1, bound);
    cuts.push_back(std::clamp(wanted[part], low, high));
  }
  cuts.push_back(layers.n_layers);
  return cuts;
}

Layers layers_across(int axis, const LoadTable& table, const std::array<Cuts, 3>& cuts) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  Layers layers;
  layers.n_layers = table.n_tiles()[axis];
  layers.n_columns = static_cast<int>((cuts[b].size() - 1) * (cuts[c].size() - 1));
  layers.load.reserve(static_cast<std::size_t>(layers.n_layers) * layers.n_columns);
  Int3 from, to;
  for (int layer = 0; layer < table.n_tiles()[axis]; ++layer)
    for (std::size_t p = 0; p + 1 < cuts[b].size(); ++p)
      for (std::size_t q = 0; q + 1 < cuts[c].size(); ++q) {
        from[axis] = layer, to[axis] = layer + 1;
        from[b] = cuts[b][p], to[b] = cuts[b][p + 1];
        from[c] = cuts[c][q], to[c] = cuts[c][q + 1];
        layers.load.push_back(table.box(from, to));
      }
  return layers;
}

GlobalIndex largest_load(const LoadTable& table, const std::array<Cuts, 3>& cuts) {
  GlobalIndex largest = 0;
  for (std::size_t i = 0; i + 1 < cuts[0].size(); ++i)
    for (std::size_t j = 0; j + 1 < cuts[1].size(); ++j)
      for (std::size_t k = 0; k + 1 < cuts[2].size(); ++k)
        largest = std::max(
            largest, table.box({cuts[0][i], cuts[1][j], cuts[2][k]}, {cuts[0][i + 1], cuts[1][j + 1], cuts[2][k + 1]}));
  return largest;
}

Cuts equal_cuts(int n_tiles, int n_parts) {
  Cuts cuts(n_parts + 1);
  for (int part = 0; part <= n_parts; ++part)
    cuts[part] = static_cast<int>(static_cast<GlobalIndex>(n_tiles) * part / n_parts);
  return cuts;
}

// Each axis by itself first, then one axis after the other given the cuts of the other two, while that helps. Last, the
// cuts move towards equal parts as far as the largest load allows with 2 % more: an owner's memory is its nodes, not its
// particles.
std::array<Cuts, 3> balanced_cuts(const LoadTable& table, const Int3& n_ranks) {
  const Int3& n_tiles = table.n_tiles();
  const std::array<Cuts, 3> whole{Cuts{0, n_tiles[0]}, Cuts{0, n_tiles[1]}, Cuts{0, n_tiles[2]}};
  std::array<Cuts, 3> cuts;
  for (int axis = 0; axis < 3; ++axis) cuts[axis] = smallest_load_cuts(layers_across(axis, table, whole), n_ranks[axis]);

  GlobalIndex largest = largest_load(table, cuts);
  for (bool improved = true; improved;) {
    improved = false;
    for (int axis = 0; axis < 3; ++axis) {
      std::array<Cuts, 3> trial = cuts;
      trial[axis] = smallest_load_cuts(layers_across(axis, table, cuts), n_ranks[axis]);
      const GlobalIndex trial_largest = largest_load(table, trial);
      if (trial_largest >= largest) continue;
      cuts = std::move(trial);
      largest = trial_largest;
      improved = true;
    }
  }
  for (int axis = 0; axis < 3; ++axis)
    cuts[axis] =
        nearest_cuts(layers_across(axis, table, cuts), equal_cuts(n_tiles[axis], n_ranks[axis]), largest + largest / 50);
  return cuts;
}

GlobalIndex cut_surface(const GridGeometry& grid, const Int3& n_ranks) {
  GlobalIndex surface = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int n_cuts = n_ranks[axis] > 1 && grid.periodic[axis] ? n_ranks[axis] : n_ranks[axis] - 1;
    surface += static_cast<GlobalIndex>(n_cuts) * grid.n_nodes((axis + 1) % 3) * grid.n_nodes((axis + 2) % 3);
  }
  return surface;
}

// The ways to write n_ranks as a product of three numbers that fit into the tiles. Many parts along x and few along z come
// first, and are taken when all else is equal: what falls and spreads on a floor moves from rank to rank where z is cut, and
// the balance is lost.
std::vector<Int3> process_grids(const Int3& n_tiles, int n_ranks) {
  std::vector<Int3> result;
  for (int px = std::min(n_ranks, n_tiles[0]); px >= 1; --px) {
    if (n_ranks % px != 0) continue;
    for (int py = std::min(n_ranks / px, n_tiles[1]); py >= 1; --py) {
      const int pz = n_ranks / px / py;
      if (n_ranks / px % py == 0 && pz <= n_tiles[2]) result.push_back({px, py, pz});
    }
  }
  return result;
}

std::vector<Candidate> candidates(const GridGeometry& grid, const LoadTable& table, bool uniform, int n_ranks) {
  std::vector<Candidate> result;
  for (const Int3& process_grid : process_grids(table.n_tiles(), n_ranks)) {
    Candidate c;
    c.n_ranks = process_grid;
    if (uniform)
      for (int axis = 0; axis < 3; ++axis) c.cuts[axis] = equal_cuts(table.n_tiles()[axis], c.n_ranks[axis]);
    else
      c.cuts = balanced_cuts(table, c.n_ranks);
    c.largest_load = largest_load(table, c.cuts);
    c.surface = cut_surface(grid, c.n_ranks);
    result.push_back(std::move(c));
  }
  return result;
}

const Candidate& best_of(const std::vector<Candidate>& all) {
  GlobalIndex smallest = all.front().largest_load;
  for (const Candidate& c : all) smallest = std::min(smallest, c.largest_load);
  const Candidate* best = nullptr;
  for (const Candidate& c : all) {
    if (c.largest_load > smallest + smallest / 20) continue;
    if (!best || c.surface < best->surface || (c.surface == best->surface && c.largest_load < best->largest_load)) best = &c;
  }
  return *best;
}

// What a tile counts: its load, plus a constant that is about 1 % of the load when summed over all tiles. The last layer of
// tiles is added to the one before it, where the two may not be cut apart.
std::vector<GlobalIndex> counted_loads(const GridGeometry& grid, const Int3& divisible, bool uniform, const TileLoad& load) {
  const auto n_tiles = static_cast<GlobalIndex>(grid.n_tiles());
  const GlobalIndex total = load.total();
  const GlobalIndex scale = uniform || total == 0 ? 0 : (100 * n_tiles + total - 1) / total;
  const GlobalIndex constant = std::max<GlobalIndex>(1, scale * total / (100 * n_tiles));
  std::vector<GlobalIndex> result(static_cast<std::size_t>(divisible[0]) * divisible[1] * divisible[2], 0);
  const auto at = [&](Int3 tile) -> GlobalIndex& {
    for (int axis = 0; axis < 3; ++axis) tile[axis] = std::min(tile[axis], divisible[axis] - 1);
    return result[(static_cast<std::size_t>(tile[0]) * divisible[1] + tile[1]) * divisible[2] + tile[2]];
  };
  for (int x = 0; x < grid.n_tiles(0); ++x)
    for (int y = 0; y < grid.n_tiles(1); ++y)
      for (int z = 0; z < grid.n_tiles(2); ++z) at({x, y, z}) += constant;
  for (std::size_t t = 0; t < load.size(); ++t) at(grid.tile_coordinates(load.tile[t])) += scale * load.weight[t];
  return result;
}

double imbalance_of(const LoadTable& table, const std::array<Cuts, 3>& cuts, int n_ranks) {
  return static_cast<double>(largest_load(table, cuts)) * n_ranks / static_cast<double>(table.total());
}

}  // namespace

Cuts cut_chain(const std::vector<GlobalIndex>& loads, int n_parts) {
  const Layers chain{static_cast<int>(loads.size()), 1, loads};
  Cuts cuts = smallest_load_cuts(chain, n_parts);
  GlobalIndex largest = 0, total = 0;
  for (int part = 0; part < n_parts; ++part) {
    const GlobalIndex load = std::accumulate(loads.begin() + cuts[part], loads.begin() + cuts[part + 1], GlobalIndex{0});
    largest = std::max(largest, load);
    total += load;
  }
  Cuts equal{0};
  GlobalIndex before = 0;
  for (int n = 0; n < chain.n_layers; ++n) {
    // The cut goes where the sum so far is nearest to its share of the total.
    while (static_cast<int>(equal.size()) < n_parts &&
           static_cast<double>(before) + 0.5 * static_cast<double>(loads[n]) >=
               static_cast<double>(total) / n_parts * static_cast<double>(equal.size()))
      equal.push_back(n);
    before += loads[n];
  }
  while (static_cast<int>(equal.size()) <= n_parts) equal.push_back(chain.n_layers);
  return nearest_cuts(chain, equal, largest);
}

std::string box_fault(const GridGeometry& grid, int n_ranks) {
  if (!process_grids(separable_tiles(grid), n_ranks).empty()) return {};
  return fmt::format("the grid has {} x {} x {} tiles of {} nodes per axis, too few to give each of {} ranks a box of them",
                     grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2), tile_width, n_ranks);
}

std::optional<Boxes> cut_boxes(const GridGeometry& grid, bool uniform, const TileLoad& load, int n_ranks) {
  const Int3 divisible = separable_tiles(grid);
  if (process_grids(divisible, n_ranks).empty()) return std::nullopt;
  const LoadTable table(divisible, counted_loads(grid, divisible, uniform, load));
  Candidate best = best_of(candidates(grid, table, uniform, n_ranks));
  Boxes boxes;
  boxes.n_ranks = best.n_ranks;
  boxes.imbalance = imbalance_of(table, best.cuts, n_ranks);
  for (int axis = 0; axis < 3; ++axis) {
    best.cuts[axis].back() = grid.n_tiles(axis);
    for (int part = 0; part < best.n_ranks[axis]; ++part)
      boxes.nodes[axis].push_back((best.cuts[axis][part + 1] - best.cuts[axis][part]) * tile_width);
    boxes.nodes[axis].back() -= grid.n_tiles(axis) * tile_width - grid.n_nodes(axis);
  }
  return boxes;
}

double box_imbalance(const GridGeometry& grid, const Boxes& boxes, const TileLoad& load) {
  const Int3 divisible = separable_tiles(grid);
  const LoadTable table(divisible, counted_loads(grid, divisible, false, load));
  std::array<Cuts, 3> cuts;
  for (int axis = 0; axis < 3; ++axis) {
    cuts[axis].push_back(0);
    for (const int nodes : boxes.nodes[axis]) cuts[axis].push_back(cuts[axis].back() + nodes / tile_width);
    cuts[axis].back() = divisible[axis];
  }
  return imbalance_of(table, cuts, boxes.n_ranks[0] * boxes.n_ranks[1] * boxes.n_ranks[2]);
}

}  // namespace bulkley
