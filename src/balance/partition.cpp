#include "balance/partition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <map>

#include "balance/bisection.hpp"
#include "balance/diffusion.hpp"
#include "balance/graph_parts.hpp"
#include "balance/ranges.hpp"
#include "balance/traffic.hpp"
#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

// Boxes stay until their imbalance has grown by this factor since they were cut.
constexpr double boxes_slack = 1.2;

// So much faster must a step be than with boxes. Boxes are cut across x and y first, so that what falls and spreads stays
// with its rank; how long the loads of another map stay even is not predicted.
constexpr double worth_leaving_boxes = 1.02;

// Numbers the parts so that, greedily, most load stays with the rank that has it.
std::vector<std::int32_t> relabelled(const TileLoad& load, const std::vector<std::int32_t>& part, const TileMap& present) {
  const int n_ranks = present.n_ranks();
  std::map<std::pair<std::int32_t, std::int32_t>, GlobalIndex> overlap;  // of {part, rank}
  for (std::size_t t = 0; t < load.size(); ++t) overlap[{part[t], present.owner(load.tile[t])}] += load.weight[t];
  std::vector<std::pair<GlobalIndex, std::pair<std::int32_t, std::int32_t>>> order;
  for (const auto& [pair, weight] : overlap) order.emplace_back(-weight, pair);
  std::sort(order.begin(), order.end());

  std::vector<std::int32_t> rank_of(static_cast<std::size_t>(n_ranks), -1);
  std::vector<bool> taken(static_cast<std::size_t>(n_ranks), false);
  for (const auto& [weight, pair] : order) {
    const auto [p, rank] = pair;
    if (rank_of[static_cast<std::size_t>(p)] >= 0 || taken[static_cast<std::size_t>(rank)]) continue;
    rank_of[static_cast<std::size_t>(p)] = rank;
    taken[static_cast<std::size_t>(rank)] = true;
  }
  std::int32_t free = 0;
  for (std::int32_t& rank : rank_of) {
    if (rank >= 0) continue;
    while (taken[static_cast<std::size_t>(free)]) ++free;
    rank = free++;
  }
  std::vector<std::int32_t> result(part.size());
  for (std::size_t t = 0; t < part.size(); ++t) result[t] = rank_of[static_cast<std::size_t>(part[t])];
  return result;
}

// Owners of all tiles from those of the loaded ones, `part`: an empty tile joins the first neighbour by a face that has an
// owner, layer by layer. Without any load `otherwise` stays.
TileMap spread(const GridGeometry& grid, const TileLoad& load, int n_ranks, const std::vector<std::int32_t>& part,
               const TileMap& otherwise) {
  if (load.size() == 0) return otherwise;
  std::vector<std::int32_t> owner(static_cast<std::size_t>(grid.n_tiles()), -1);
  std::vector<TileIndex> layer = load.tile, next;
  for (std::size_t t = 0; t < load.size(); ++t) owner[static_cast<std::size_t>(load.tile[t])] = part[t];
  while (!layer.empty()) {
    next.clear();
    for (const TileIndex tile : layer) {
      const Int3 here = grid.tile_coordinates(tile);
      for (int axis = 0; axis < 3; ++axis)
        for (const int d : {-1, 1}) {
          Int3 step{0, 0, 0};
          step[axis] = d;
          const TileIndex there = grid.neighbour(here, step);
          if (there < 0 || owner[static_cast<std::size_t>(there)] >= 0) continue;
          owner[static_cast<std::size_t>(there)] = owner[static_cast<std::size_t>(tile)];
          next.push_back(there);
        }
    }
    layer.swap(next);
  }
  return {n_ranks, std::move(owner)};
}

// Owners of the loaded tiles.
std::vector<std::int32_t> parts_of(const TileMap& map, const TileLoad& load) {
  std::vector<std::int32_t> part;
  part.reserve(load.size());
  for (const TileIndex tile : load.tile) part.push_back(map.owner(tile));
  return part;
}

// Parts of the graph, with loads brought near their mean; none where METIS fails, which leaves them to the curve.
std::optional<std::vector<std::int32_t>> metis_parts(const GridGeometry& grid, const TileLoad& load, int n_ranks,
                                                     PartitionNotes& notes) {
  const TileGraph graph = tile_graph(grid, load);
  std::string fault;
  if (auto part = graph_parts(graph, load, n_ranks, fault))
    return diffused(graph, load, std::move(*part), n_ranks, target_imbalance);
  notes.method = PartitionMethod::hilbert;
  notes.warnings.push_back(fmt::format("METIS cannot divide the tiles ({}); they are cut along a Hilbert curve", fault));
  return std::nullopt;
}

// Those of `present` while their imbalance allows.
std::optional<Boxes> boxes_for(const GridGeometry& grid, const TileLoad& load, int n_ranks, const Partition* present) {
  if (present && present->boxes && box_imbalance(grid, *present->boxes, load) <= boxes_slack * present->boxes->imbalance)
    return present->boxes;
  WholeRegion all;
  return cut_boxes(grid, false, load, n_ranks, all);
}

// The map where no load decides; where there is a load and there are no boxes, one without tiles.
TileMap map_without_load(const GridGeometry& grid, const std::optional<Boxes>& boxes, const TileLoad& load, int n_ranks,
                         RankHalves halves) {
  if (boxes) return map_of_boxes(grid, *boxes);
  if (load.size() > 0) return {n_ranks, {}};
  return TileMap(even_cuts(grid, n_ranks, halves));
}

RankHalves halves_of(const PartitionSettings& settings) { return {std::max(1, settings.ranks_per_node)}; }

Partition cut_partition(const GridGeometry& grid, PartitionMethod method, const TileLoad& load, int n_ranks,
                        const Partition* present, RankHalves halves) {
  const Cutting cutting = method == PartitionMethod::hilbert ? Cutting::curve : Cutting::planes;
  const CutTree* const tree = present ? present->map.tree() : nullptr;
  if (tree && tree->cutting() == cutting && tree->halves() == halves)
    return *recut(grid, load, *present, KeptCuts::usual_tolerance);
  return {TileMap(bisected(grid, cutting, load, n_ranks, {}, halves)), {}};
}

}  // namespace

Partition partition_of_boxes(const GridGeometry& grid, bool uniform, const TileLoad& load, int n_ranks, RegionSums& sums) {
  std::optional<Boxes> boxes = cut_boxes(grid, uniform, load, n_ranks, sums);
  if (!boxes)
    throw UsageError(fmt::format("{}; use another number of ranks, a finer grid, or partition.method = \"auto\"",
                                 box_fault(grid, n_ranks)));
  TileMap map = map_of_boxes(grid, *boxes);
  return {std::move(map), std::move(boxes)};
}

Partition make_partition(const GridGeometry& grid, const PartitionSettings& settings, const TileLoad& load, int n_ranks,
                         const Partition* present, const CostModel& cost, PartitionNotes* notes) {
  PartitionNotes unread;
  PartitionNotes& note = notes ? *notes : unread;
  note = {settings.method};
  if (settings.method == PartitionMethod::uniform || settings.method == PartitionMethod::ranges || n_ranks == 1) {
    note.method = settings.method == PartitionMethod::uniform ? settings.method : PartitionMethod::ranges;
    WholeRegion all;
    return partition_of_boxes(grid, note.method == PartitionMethod::uniform, load, n_ranks, all);
  }
  const RankHalves halves = halves_of(settings);
  const bool too_many =
      load.size() > most_tiles_on_root || n_ranks > most_ranks_of_root || grid.n_tiles() > most_tiles_in_table;
  if (settings.method == PartitionMethod::automatic && too_many) note.method = PartitionMethod::bisection;
  if (note.method == PartitionMethod::bisection || note.method == PartitionMethod::hilbert)
    return cut_partition(grid, note.method, load, n_ranks, present, halves);
  const std::optional<Boxes> boxes = boxes_for(grid, load, n_ranks, present);
  const TileMap idle = map_without_load(grid, boxes, load, n_ranks, halves);
  const auto spread_out = [&](std::vector<std::int32_t> part) {
    if (present) part = relabelled(load, part, present->map);
    return Partition{spread(grid, load, n_ranks, part, idle), boxes};
  };
  const auto by = [&](PartitionMethod method) {
    note.method = method;
    if (method == PartitionMethod::metis)
      if (auto part = metis_parts(grid, load, n_ranks, note)) return spread_out(std::move(*part));
    const Cutting cutting = note.method == PartitionMethod::hilbert ? Cutting::curve : Cutting::planes;
    return Partition{TileMap(bisected(grid, cutting, load, n_ranks, {}, halves)), boxes};
  };
  if (settings.method != PartitionMethod::automatic) return by(settings.method);

  // Boxes have the fewest neighbours, METIS and bisection share fewer nodes than the curve, the curve has the least imbalance.
  const auto time_of = [&](const Partition& partition) {
    return predicted_step(predict_traffic(grid, partition.map, load), cost);
  };
  Partition best{idle, boxes};
  PartitionNotes best_note{PartitionMethod::ranges};
  double fastest = std::numeric_limits<double>::infinity();
  if (boxes) {
    fastest = time_of(best);
    Partition shifted = std::move(rebalanced(grid, load, best)[0]);
    if (const double time = time_of(shifted); time < fastest) {
      fastest = time;
      best = std::move(shifted);
      best_note.rebalanced = true;
    }
    fastest /= worth_leaving_boxes;
  }
  for (const PartitionMethod method : {PartitionMethod::metis, PartitionMethod::bisection, PartitionMethod::hilbert}) {
    std::vector<Partition> trials{by(method)};
    if (note.method != method) continue;  // METIS could not, and the curve comes later
    if (trials[0].map.tree()) trials.push_back(spread_out(parts_of(trials[0].map, load)));
    for (Partition& trial : trials) {
      const double time = time_of(trial);
      if (time >= fastest) continue;
      fastest = time;
      best_note = {method, false, method != PartitionMethod::metis && !trial.map.tree(), {}};
      best = std::move(trial);
    }
  }
  note = best_note;
  return best;
}

std::array<Partition, 2> rebalanced(const GridGeometry& grid, const TileLoad& load, const Partition& present) {
  const TileGraph graph = tile_graph(grid, load);
  const std::vector<std::int32_t> before = parts_of(present.map, load);
  const int n_ranks = present.map.n_ranks();
  std::array<Partition, 2> result{present, present};
  for (std::size_t way = 0; way < 2; ++way) {
    const auto moved = way == 0 ? diffused : relieved;
    result[way].map = spread(grid, load, n_ranks, moved(graph, load, before, n_ranks, target_imbalance), present.map);
  }
  return result;
}

std::optional<Partition> recut(const GridGeometry& grid, const TileLoad& load, const Partition& present, double tolerance) {
  const CutTree* const tree = present.map.tree();
  if (!tree) return std::nullopt;
  return Partition{TileMap(bisected(grid, tree->cutting(), load, tree->n_ranks(), {tree, tolerance}, tree->halves())),
                   present.boxes};
}

std::string boxes_text(const std::optional<Boxes>& boxes) {
  if (!boxes) return {};
  return fmt::format(" ({} x {} x {})", boxes->n_ranks[0], boxes->n_ranks[1], boxes->n_ranks[2]);
}

TileMap map_of_boxes(const GridGeometry& grid, const Boxes& boxes) {
  BoxOwners owners{boxes.n_ranks[0] * boxes.n_ranks[1] * boxes.n_ranks[2], {}};
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t p = 0; p < boxes.nodes[axis].size(); ++p) {
      Int3 process{0, 0, 0};
      process[axis] = static_cast<int>(p);
      owners.of[axis].insert(owners.of[axis].end(), (boxes.nodes[axis][p] + tile_width - 1) / tile_width,
                             boxes.rank_of(process));
    }
  TileMap map(std::move(owners));
  BULKLEY_ASSERT(map.n_tiles() == grid.n_tiles());
  return map;
}

double imbalance(const std::vector<GlobalIndex>& values) {
  const GlobalIndex total = std::accumulate(values.begin(), values.end(), GlobalIndex{0});
  if (total == 0) return 1.0;
  return static_cast<double>(*std::max_element(values.begin(), values.end())) * static_cast<double>(values.size()) /
         static_cast<double>(total);
}

GlobalIndex n_moved(const TileMap& from, const TileMap& to, const TileLoad& load) {
  GlobalIndex n = 0;
  for (std::size_t t = 0; t < load.size(); ++t)
    if (from.owner(load.tile[t]) != to.owner(load.tile[t])) n += load.count[t];
  return n;
}

GlobalIndex busiest_moves(const TileMap& from, const TileMap& to, const TileLoad& load) {
  std::vector<GlobalIndex> of_rank(static_cast<std::size_t>(from.n_ranks()), 0);
  for (std::size_t t = 0; t < load.size(); ++t) {
    const std::int32_t before = from.owner(load.tile[t]), after = to.owner(load.tile[t]);
    if (before == after) continue;
    of_rank[static_cast<std::size_t>(before)] += load.count[t];
    of_rank[static_cast<std::size_t>(after)] += load.count[t];
  }
  return *std::max_element(of_rank.begin(), of_rank.end());
}

}  // namespace bulkley
