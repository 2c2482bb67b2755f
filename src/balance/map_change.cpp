#include "balance/map_change.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "balance/bisection.hpp"
#include "balance/traffic.hpp"

namespace bulkley {

namespace {

constexpr double least_gain = 0.02;  // of the time of a step

}  // namespace

Change worthwhile_change(const GridGeometry& grid, const TileLoad& load, const Partition& present, const CostModel& cost,
                         const ChangeCost& change, double horizon, double fresh_exchange, int ranks_per_node) {
  const int n_ranks = present.map.n_ranks();
  const double now = predicted_step(predict_traffic(grid, present.map, load), cost);
  const double mean = 1e-12 * static_cast<double>(load.total()) / n_ranks;
  // Tiles are not divided: with few of them for each rank the heaviest is the limit, not the mean.
  const GlobalIndex heaviest = load.size() > 0 ? *std::max_element(load.weight.begin(), load.weight.end()) : 0;
  const double reachable = std::max(target_imbalance * mean, 1e-12 * static_cast<double>(heaviest)) + fresh_exchange;
  if (now - reachable < least_gain * now || (now - reachable) * horizon <= change.rebuild) return {};

  struct Candidate {
    Partition partition;
    double step, net;  // s: of a step; saved over the horizon less the cost
  };
  const auto evaluated = [&](Partition partition, double making) {
    const double step = predicted_step(predict_traffic(grid, partition.map, load), cost);
    const double moving = change.particle * static_cast<double>(busiest_moves(present.map, partition.map, load));
    return Candidate{std::move(partition), step, (now - step) * horizon - making - change.rebuild - moving};
  };
  auto [handed_on, straight] = rebalanced(grid, load, present);
  Candidate best = evaluated(std::move(handed_on), 0.0);
  if (Candidate other = evaluated(std::move(straight), 0.0); other.net > best.net) best = std::move(other);

  for (const double tolerance : {KeptCuts::usual_tolerance, KeptCuts::tight_tolerance})
    if (std::optional<Partition> cut = recut(grid, load, present, tolerance))
      if (Candidate other = evaluated(std::move(*cut), 0.0); other.net > best.net) best = std::move(other);

  Change result;
  const double making = change.tile * static_cast<double>(load.size());
  const bool more_to_gain = best.step - reachable > least_gain * now;
  if (more_to_gain && (now - reachable) * horizon - making - change.rebuild > std::max(best.net, 0.0)) {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    PartitionSettings settings;
    settings.ranks_per_node = ranks_per_node;
    Candidate whole = evaluated(make_partition(grid, settings, load, n_ranks, &present, cost), making);
    result.making = std::chrono::duration<double>(Clock::now() - begin).count();
    result.whole = whole.net > best.net;
    if (result.whole) best = std::move(whole);
  }
  if (best.net > 0.0 && now - best.step >= least_gain * now) result.partition = std::move(best.partition);
  return result;
}

}  // namespace bulkley
