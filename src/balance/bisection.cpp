#include "balance/bisection.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

// How a cut is found.
//
// Tiles of a region are numbered along each axis a within the box around them, by (c_a, c_{a+1}, c_{a+2}): a cut is a number.
// All axes are searched at once; a curve has one, along which its places are numbered likewise. In each round the interval that holds the cut is divided into bins; the loads and
// numbers of tiles in them, summed over the participants, say in which bin the share of the lower side is reached, and the
// search continues there until bins are single tiles: two rounds for 64^3 tiles in the box, four for 2600^3. All sums are of
// integers, so that the answer depends neither on their order nor on who holds which tile.

namespace bulkley {

namespace {

constexpr GlobalIndex n_bins = 256;  // an axis; 12 kB a message
constexpr GlobalIndex none = std::numeric_limits<GlobalIndex>::max();

// Numbers of tiles along one axis, within a box.
class Numbering {
 public:
  Numbering(int axis, const Int3& low, const Int3& high) : axis_(axis), low_(low) {
    for (std::size_t n = 0; n < 3; ++n) size_[n] = high[along(n)] - low[along(n)] + 1;
  }
  GlobalIndex size() const { return size_[0] * size_[1] * size_[2]; }
  GlobalIndex number(const Int3& at) const {
    GlobalIndex result = 0;
    for (std::size_t n = 0; n < 3; ++n) result = result * size_[n] + (at[along(n)] - low_[along(n)]);
    return result;
  }
  Int3 tile(GlobalIndex number) const {
    Int3 at;
    for (std::size_t n = 3; n-- > 0; number /= size_[n]) at[along(n)] = low_[along(n)] + static_cast<int>(number % size_[n]);
    return at;
  }
  std::size_t along(std::size_t n) const { return (static_cast<std::size_t>(axis_) + n) % 3; }
  int axis() const { return axis_; }

 private:
  int axis_;
  Int3 low_;
  std::array<GlobalIndex, 3> size_{};
};

// Where the search along one axis stands: the cut is among the numbers begin .. begin + size - 1; the tiles before them have
// this load and number.
struct Interval {
  GlobalIndex begin, size, load = 0, count = 0;
};

// How much belongs below a cut.
struct Share {
  GlobalIndex load;         // wanted
  GlobalIndex least, most;  // tiles

  bool more(GlobalIndex load_below, GlobalIndex n_below) const {
    return n_below <= least || (n_below <= most && load_below <= load);
  }
};

Share share_of(GlobalIndex total, GlobalIndex n_tiles, int n_ranks, int below) {
  __extension__ using Wide = __int128;
  const GlobalIndex rest = n_tiles - (n_ranks - below);  // leaves a tile for each rank above
  return {static_cast<GlobalIndex>(Wide{total} * below / n_ranks),
          std::max<GlobalIndex>(0, std::min<GlobalIndex>(below, rest)),
          std::min(n_tiles, std::max<GlobalIndex>(below, rest))};
}

using Axes = std::vector<Numbering>;         // all three, or the one of a curve
using Numbers = std::array<GlobalIndex, 3>;  // of tiles, along each of the axes

// For each axis the number of the first tile above the cut.
Numbers search(std::span<const TileRecord> records, const Axes& axes, const Share& share, RegionSums& sums) {
  std::array<Interval, 3> intervals;
  intervals.fill({0, axes[0].size()});
  std::vector<GlobalIndex> bins(axes.size() * 2 * n_bins);  // load and number of tiles
  const auto bin = [&bins](std::size_t a, GlobalIndex n) {
    return std::span(bins).subspan(2 * (a * n_bins + static_cast<std::size_t>(n)), 2);
  };
  Numbers thresholds{};
  for (GlobalIndex width = 0; width != 1;) {
    width = (intervals[0].size + n_bins - 1) / n_bins;
    std::fill(bins.begin(), bins.end(), 0);
    for (const TileRecord& record : records)
      for (std::size_t a = 0; a < axes.size(); ++a) {
        const GlobalIndex n = axes[a].number(record.at) - intervals[a].begin;
        if (n < 0 || n >= intervals[a].size) continue;
        bin(a, n / width)[0] += record.weight;
        ++bin(a, n / width)[1];
      }
    sums.combine(bins, bins.size());
    for (std::size_t a = 0; a < axes.size(); ++a) {
      GlobalIndex n = 0;  // the last bin at whose beginning there is room for more below
      Interval next = intervals[a];
      const auto after = [&] {
        return Interval{next.begin + width, width, next.load + bin(a, n)[0], next.count + bin(a, n)[1]};
      };
      for (Interval end = after(); n + 1 < n_bins && share.more(end.load, end.count); end = after()) {
        next = end;
        ++n;
      }
      next.size = width;
      intervals[a] = next;
      const Interval with = after();  // the one tile left: it goes where the lower side comes nearer to its share
      const bool goes = with.count <= share.most && with.load - share.load < share.load - next.load;
      thresholds[a] = next.begin + (goes ? 1 : 0);
    }
  }
  return thresholds;
}

// A threshold between two tiles that follow each other along an axis: in the middle of what lies between them.
Cut between(const Numbering& axis, const Int3& last_below, const Int3& first_above) {
  Int3 threshold{0, 0, 0};
  for (std::size_t n = 0; n < 3; ++n) {
    const std::size_t a = axis.along(n);
    threshold[a] = last_below[a];
    if (last_below[a] == first_above[a]) continue;
    threshold[a] = (last_below[a] + first_above[a] + 1) / 2;
    break;
  }
  return {axis.axis(), threshold};
}

Cut just_above(const Numbering& axis, Int3 tile) {
  ++tile[axis.along(2)];
  return {axis.axis(), tile};
}

// The cuts, moved to the middle of the empty space that they are in.
std::vector<Cut> centred(std::span<const TileRecord> records, const Axes& axes, const Numbers& thresholds,
                         RegionSums& sums) {
  const std::size_t n_axes = axes.size();
  std::vector<GlobalIndex> nearest(2 * n_axes, none);  // the negative of the last number below, the first above
  for (const TileRecord& record : records)
    for (std::size_t a = 0; a < n_axes; ++a) {
      const GlobalIndex n = axes[a].number(record.at);
      GlobalIndex& limit = nearest[n < thresholds[a] ? a : n_axes + a];
      limit = std::min(limit, n < thresholds[a] ? -n : n);
    }
  sums.combine(nearest, 0);
  std::vector<Cut> cuts(n_axes);
  for (std::size_t a = 0; a < n_axes; ++a) {
    const bool some_below = nearest[a] != none, some_above = nearest[n_axes + a] != none;
    if (some_below && some_above)
      cuts[a] = between(axes[a], axes[a].tile(-nearest[a]), axes[a].tile(nearest[n_axes + a]));
    else if (some_above)
      cuts[a] = {axes[a].axis(), axes[a].tile(nearest[n_axes + a])};
    else
      cuts[a] = just_above(axes[a], axes[a].tile(-nearest[a]));
  }
  return cuts;
}

}  // namespace

// What is known of a region.
struct Bisection::Region {
  GlobalIndex load = 0, n_tiles = 0;
  GlobalIndex old_load = 0, old_tiles = 0;  // below the old cut, if there is one
  Int3 low{0, 0, 0}, high{0, 0, 0};         // corners of the box around the tiles
};

Cut Bisection::cut(std::span<const TileRecord> records, int first, int n_ranks, int depth, RegionSums& sums) const {
  std::optional<Cut> old;
  if (kept_.present) old = kept_.present->cuts()[halves_.cut_of(first, n_ranks)];
  const Region region = survey(records, old, sums);
  if (old && serves(region, n_ranks, depth)) return *old;
  if (region.n_tiles == 0) return {};
  return best_cut(records, region, n_ranks, old, sums);
}

Bisection::Region Bisection::survey(std::span<const TileRecord> records, const std::optional<Cut>& old,
                                    RegionSums& sums) const {
  // Four sums, the low corner, the negative of the high one.
  std::array<GlobalIndex, 10> values{0, 0, 0, 0, none, none, none, none, none, none};
  for (const TileRecord& record : records) {
    values[0] += record.weight;
    ++values[1];
    if (old && old->below(record.at)) {
      values[2] += record.weight;
      ++values[3];
    }
    for (std::size_t a = 0; a < 3; ++a) {
      values[4 + a] = std::min<GlobalIndex>(values[4 + a], record.at[a]);
      values[7 + a] = std::min<GlobalIndex>(values[7 + a], -record.at[a]);
    }
  }
  sums.combine(values, 4);
  Region region{values[0], values[1], values[2], values[3]};
  if (region.n_tiles == 0) return region;
  for (std::size_t a = 0; a < 3; ++a) {
    region.low[a] = static_cast<int>(values[4 + a]);
    region.high[a] = static_cast<int>(-values[7 + a]);
  }
  return region;
}

bool Bisection::serves(const Region& region, int n_ranks, int depth) const {
  const int below = halves_.n_below(n_ranks);
  const Share share = share_of(region.load, region.n_tiles, n_ranks, below);
  if (kept_.tolerance < 0.0 || region.old_tiles < share.least || region.old_tiles > share.most) return false;
  const int largest_depth = std::bit_width(static_cast<unsigned>(n_ranks_ - 1));
  const double bound =
      static_cast<double>(total_) / n_ranks_ * (1.0 + kept_.tolerance * std::min(depth + 1, largest_depth) / largest_depth);
  return static_cast<double>(region.old_load) <= bound * below &&
         static_cast<double>(region.load - region.old_load) <= bound * (n_ranks - below);
}

Cut Bisection::best_cut(std::span<const TileRecord> records, const Region& region, int n_ranks,
                        const std::optional<Cut>& old, RegionSums& sums) const {
  Axes axes;
  for (int axis = 0; axis < (cutting_ == Cutting::curve ? 1 : 3); ++axis) axes.emplace_back(axis, region.low, region.high);
  const std::vector<Cut> cuts =
      centred(records, axes,
              search(records, axes, share_of(region.load, region.n_tiles, n_ranks, halves_.n_below(n_ranks)), sums), sums);
  if (cutting_ == Cutting::curve) return cuts[0];
  std::array<GlobalIndex, 3> faces{0, 0, 0};  // of loaded tiles below to tiles above
  for (const TileRecord& record : records)
    for (std::size_t a = 0; a < 3; ++a) {
      if (!cuts[a].below(record.at)) continue;
      for (std::size_t d = 0; d < 3; ++d) {
        Int3 above = record.at;
        ++above[d];
        faces[a] += above[d] < n_tiles_[d] && !cuts[a].below(above);
      }
    }
  sums.combine(faces, 3);
  for (std::size_t a = 0; a < 3; ++a) faces[a] *= old && old->axis() == static_cast<int>(a) ? 4 : 5;
  const auto better = [&](std::size_t a, std::size_t b) {
    return faces[a] != faces[b] ? faces[a] < faces[b] : region.high[a] - region.low[a] > region.high[b] - region.low[b];
  };
  std::size_t best = 0;
  for (std::size_t a = 1; a < 3; ++a)
    if (better(a, best)) best = a;
  return cuts[best];
}

std::vector<TileRecord> records_of(const GridGeometry& grid, Cutting cutting, const TileLoad& load) {
  const HilbertCurve curve({grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)});
  std::vector<TileRecord> records;
  records.reserve(load.size());
  for (std::size_t t = 0; t < load.size(); ++t) {
    const Int3 tile = grid.tile_coordinates(load.tile[t]);
    records.push_back({cutting == Cutting::curve ? curve.place(tile) : tile, 0, load.weight[t], load.count[t]});
  }
  return records;
}

CutTree even_cuts(const GridGeometry& grid, int n_ranks, RankHalves halves) {
  std::vector<Cut> cuts(static_cast<std::size_t>(n_ranks - 1));
  const auto divide = [&](const auto& again, Int3 low, Int3 high, int first, int n) -> void {
    if (n == 1) return;
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
      if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
    const int below = halves.n_below(n);
    Int3 middle{0, 0, 0}, low_end = high, high_begin = low;
    middle[axis] = low[axis] + static_cast<int>(GlobalIndex{high[axis] - low[axis]} * below / n);
    low_end[axis] = high_begin[axis] = middle[axis];
    cuts[halves.cut_of(first, n)] = {static_cast<int>(axis), middle};
    again(again, low, low_end, first, below);
    again(again, high_begin, high, first + below, n - below);
  };
  divide(divide, {0, 0, 0}, {grid.n_tiles(0), grid.n_tiles(1), grid.n_tiles(2)}, 0, n_ranks);
  return {grid, std::move(cuts), Cutting::planes, halves};
}

CutTree bisected(const GridGeometry& grid, Cutting cutting, const TileLoad& load, int n_ranks, const KeptCuts& kept,
                 RankHalves halves) {
  if (load.size() == 0) return kept.present ? *kept.present : even_cuts(grid, n_ranks, halves);
  const Bisection bisection(grid, cutting, halves, n_ranks, load.total(), kept);
  std::vector<TileRecord> records = records_of(grid, cutting, load);
  std::vector<Cut> cuts(static_cast<std::size_t>(n_ranks - 1));
  WholeRegion all;
  const auto divide = [&](const auto& again, std::span<TileRecord> region, int first, int n, int depth) -> void {
    if (n == 1) return;
    const Cut cut = bisection.cut(region, first, n, depth, all);
    cuts[halves.cut_of(first, n)] = cut;
    const auto middle =
        std::partition(region.begin(), region.end(), [&](const TileRecord& record) { return cut.below(record.at); });
    const auto n_below = static_cast<std::size_t>(middle - region.begin());
    const int below = halves.n_below(n);
    again(again, region.first(n_below), first, below, depth + 1);
    again(again, region.subspan(n_below), first + below, n - below, depth + 1);
  };
  divide(divide, records, 0, n_ranks, 0);
  return {grid, std::move(cuts), cutting, halves};
}

}  // namespace bulkley
