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
// towards equal parts as far as 2 % more load allow.
// This is done for every way to write the number of ranks as a product of three; of the results within 5 % of the smallest
// largest load the one with the least cut surface is taken. Whoever has part of the tiles adds its own into the layers, and their
// sums are all that the rest sees: nobody needs all tiles. Memory: a number for each layer and column, tiles along an axis times the ranks
// across it.

namespace bulkley {

namespace {

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

GlobalIndex largest_box(const Layers& layers, const Cuts& cuts) {
  GlobalIndex largest = 0;
  for (std::size_t part = 0; part + 1 < cuts.size(); ++part) {
    std::vector<GlobalIndex> filled(static_cast<std::size_t>(layers.n_columns), 0);
    for (int layer = cuts[part]; layer < cuts[part + 1]; ++layer)
      for (int c = 0; c < layers.n_columns; ++c)
        filled[c] += layers.load[static_cast<std::size_t>(layer) * layers.n_columns + c];
    largest = std::max(largest, *std::max_element(filled.begin(), filled.end()));
  }
  return largest;
}

// Part of each layer.
std::vector<int> parts_of_layers(const Cuts& cuts) {
  std::vector<int> part(static_cast<std::size_t>(cuts.back()));
  for (std::size_t p = 0; p + 1 < cuts.size(); ++p)
    std::fill(part.begin() + cuts[p], part.begin() + cuts[p + 1], static_cast<int>(p));
  return part;
}

// What tiles count: their load, of which every participant has a part, plus a constant that is about 1 % of the load when summed over
// all tiles of the box. The last layer of tiles is added to the one before it, where the two may not be cut apart. Without any load, and for
// uniform boxes, the constant is all; nothing is sent then.
class CountedLoad {
 public:
  CountedLoad(const GridGeometry& grid, bool uniform, const TileLoad& load, RegionSums& sums)
      : n_tiles_(separable_tiles(grid)), sums_(sums) {
    for (int axis = 0; axis < 3; ++axis) n_joined_[axis] = grid.n_tiles(axis) - n_tiles_[axis];
    GlobalIndex total = 0;
    if (!uniform) {
      total = load.total();
      sums_.combine({&total, 1}, 1);
    }
    const auto n_tiles = static_cast<GlobalIndex>(grid.n_tiles());
    const GlobalIndex scale = total == 0 ? 0 : (100 * n_tiles + total - 1) / total;
    constant_ = std::max<GlobalIndex>(1, scale * total / (100 * n_tiles));
    total_ = scale * total + constant_ * n_tiles;
    has_load_ = scale > 0;
    if (!has_load_) return;
    tiles_.reserve(load.size());
    for (std::size_t t = 0; t < load.size(); ++t) {
      Int3 at = grid.tile_coordinates(load.tile[t]);
      for (int axis = 0; axis < 3; ++axis) at[axis] = std::min(at[axis], n_tiles_[axis] - 1);
      tiles_.push_back({at, scale * load.weight[t]});
    }
  }

  const Int3& n_tiles() const { return n_tiles_; }
  GlobalIndex total() const { return total_; }

  /// The same for every participant. Collective among them.
  Layers layers_across(int axis, const std::array<Cuts, 3>& cuts) const {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    const auto n_b = static_cast<int>(cuts[b].size()) - 1, n_c = static_cast<int>(cuts[c].size()) - 1;
    Layers layers{n_tiles_[axis], n_b * n_c, {}};
    layers.load.resize(static_cast<std::size_t>(layers.n_layers) * layers.n_columns, 0);
    if (has_load_) {
      const std::vector<int> part_b = parts_of_layers(cuts[b]), part_c = parts_of_layers(cuts[c]);
      for (const Tile& tile : tiles_)
        layers.load[static_cast<std::size_t>(tile.at[axis]) * layers.n_columns + part_b[tile.at[b]] * n_c +
                    part_c[tile.at[c]]] += tile.counted;
      sums_.combine(layers.load, layers.load.size());
    }
    std::size_t n = 0;
    for (int layer = 0; layer < layers.n_layers; ++layer)
      for (int p = 0; p < n_b; ++p)
        for (int q = 0; q < n_c; ++q)
          layers.load[n++] += constant_ * thickness(axis, layer, layer + 1) * thickness(b, cuts[b][p], cuts[b][p + 1]) *
                              thickness(c, cuts[c][q], cuts[c][q + 1]);
    return layers;
  }

  /// Of the boxes between cuts. Collective among the participants.
  GlobalIndex largest_load(const std::array<Cuts, 3>& cuts) const {
    int axis = 0;  // with the fewest columns across
    for (int other = 1; other < 3; ++other)
      if (cuts[other].size() > cuts[axis].size()) axis = other;
    return largest_box(layers_across(axis, cuts), cuts[axis]);
  }

 private:
  struct Tile {
    Int3 at;
    GlobalIndex counted;  // without the constant
  };

  GlobalIndex thickness(int axis, int from, int to) const {
    return to - from + (to == n_tiles_[axis] ? n_joined_[axis] : 0);
  }

  Int3 n_tiles_;   // that may be cut apart
  Int3 n_joined_;  // behind them
  RegionSums& sums_;
  std::vector<Tile> tiles_;
  GlobalIndex constant_ = 1, total_ = 0;
  bool has_load_ = false;
};

Cuts equal_cuts(int n_tiles, int n_parts) {
  Cuts cuts(n_parts + 1);
  for (int part = 0; part <= n_parts; ++part)
    cuts[part] = static_cast<int>(static_cast<GlobalIndex>(n_tiles) * part / n_parts);
  return cuts;
}

// The layers across each axis that nothing cuts.
std::array<Layers, 3> whole_layers(const CountedLoad& load) {
  const Int3& n = load.n_tiles();
  const std::array<Cuts, 3> whole{Cuts{0, n[0]}, Cuts{0, n[1]}, Cuts{0, n[2]}};
  return {load.layers_across(0, whole), load.layers_across(1, whole), load.layers_across(2, whole)};
}

// Each axis by itself first, then one axis after the other given the cuts of the other two, while that helps. Last, the
// cuts move towards equal parts as far as the largest load allows with 2 % more: an owner's memory is its nodes, not its
// particles.
std::array<Cuts, 3> balanced_cuts(const CountedLoad& load, const std::array<Layers, 3>& whole, const Int3& n_ranks) {
  std::array<Cuts, 3> cuts;
  for (int axis = 0; axis < 3; ++axis) cuts[axis] = smallest_load_cuts(whole[axis], n_ranks[axis]);

  GlobalIndex largest = load.largest_load(cuts);
  for (bool improved = true; improved;) {
    improved = false;
    for (int axis = 0; axis < 3; ++axis) {
      if (n_ranks[axis] == 1) continue;
      const Layers layers = load.layers_across(axis, cuts);
      Cuts trial = smallest_load_cuts(layers, n_ranks[axis]);
      const GlobalIndex trial_largest = largest_box(layers, trial);
      if (trial_largest >= largest) continue;
      cuts[axis] = std::move(trial);
      largest = trial_largest;
      improved = true;
    }
  }
  for (int axis = 0; axis < 3; ++axis)
    if (n_ranks[axis] > 1)
      cuts[axis] = nearest_cuts(load.layers_across(axis, cuts), equal_cuts(load.n_tiles()[axis], n_ranks[axis]),
                                largest + largest / 50);
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

std::vector<Candidate> candidates(const GridGeometry& grid, const CountedLoad& load, bool uniform, int n_ranks) {
  std::vector<Candidate> result;
  const std::array<Layers, 3> whole = whole_layers(load);
  for (const Int3& process_grid : process_grids(load.n_tiles(), n_ranks)) {
    Candidate c;
    c.n_ranks = process_grid;
    if (uniform)
      for (int axis = 0; axis < 3; ++axis) c.cuts[axis] = equal_cuts(load.n_tiles()[axis], c.n_ranks[axis]);
    else
      c.cuts = balanced_cuts(load, whole, c.n_ranks);
    c.largest_load = load.largest_load(c.cuts);
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

double imbalance_of(const CountedLoad& load, GlobalIndex largest, int n_ranks) {
  return static_cast<double>(largest) * n_ranks / static_cast<double>(load.total());
}

}  // namespace

std::string box_fault(const GridGeometry& grid, int n_ranks) {
  if (!process_grids(separable_tiles(grid), n_ranks).empty()) return {};
  return fmt::format("the grid has {} x {} x {} tiles of {} nodes per axis, too few to give each of {} ranks a box of them",
                     grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2), tile_width, n_ranks);
}

std::optional<Boxes> cut_boxes(const GridGeometry& grid, bool uniform, const TileLoad& load, int n_ranks, RegionSums& sums) {
  if (!box_fault(grid, n_ranks).empty()) return std::nullopt;
  const CountedLoad counted(grid, uniform, load, sums);
  Candidate best = best_of(candidates(grid, counted, uniform, n_ranks));
  Boxes boxes;
  boxes.n_ranks = best.n_ranks;
  boxes.imbalance = imbalance_of(counted, best.largest_load, n_ranks);
  for (int axis = 0; axis < 3; ++axis) {
    best.cuts[axis].back() = grid.n_tiles(axis);
    for (int part = 0; part < best.n_ranks[axis]; ++part)
      boxes.nodes[axis].push_back((best.cuts[axis][part + 1] - best.cuts[axis][part]) * tile_width);
    boxes.nodes[axis].back() -= grid.n_tiles(axis) * tile_width - grid.n_nodes(axis);
  }
  return boxes;
}

double box_imbalance(const GridGeometry& grid, const Boxes& boxes, const TileLoad& load) {
  WholeRegion all;
  const CountedLoad counted(grid, false, load, all);
  std::array<Cuts, 3> cuts;
  for (int axis = 0; axis < 3; ++axis) {
    cuts[axis].push_back(0);
    for (const int nodes : boxes.nodes[axis]) cuts[axis].push_back(cuts[axis].back() + nodes / tile_width);
    cuts[axis].back() = counted.n_tiles()[axis];
  }
  return imbalance_of(counted, counted.largest_load(cuts), boxes.n_ranks[0] * boxes.n_ranks[1] * boxes.n_ranks[2]);
}

}  // namespace bulkley
