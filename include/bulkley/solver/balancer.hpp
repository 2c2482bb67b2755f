#pragma once
// When the particles get a new map: measures what steps cost, foresees what another map would save, and changes it if that pays.

#include <optional>

#include "bulkley/domain/partition.hpp"
#include "bulkley/domain/settings.hpp"

namespace bulkley {

class Solver;

/// What a change of maps costs, s; measured as a run goes on.
struct ChangeCost {
  double rebuild = 1e-3;   ///< of pools and exchange
  double particle = 1e-6;  ///< of each particle that the busiest rank sends or receives
  double tile = 1e-5;      ///< of making a whole new map, for each loaded tile
};

/// The partition that saves more than it costs, if there is one: over the next `horizon` steps, the predicted time of the
/// slowest rank under `present` less that under the new map must exceed the cost of the change, and be at least 2 % of it (so
/// that noise in the measured costs moves nothing). First candidate is `present` with few tiles moved (rebalanced); a whole new map
/// by `automatic` is made only where that could bring more than the making costs. Not collective.
std::optional<Partition> worthwhile_change(const GridGeometry& grid, const TileLoad& load, const Partition& present,
                                           const CostModel& cost, const ChangeCost& change, double horizon);

/// What balancing has done so far; the same on every rank but for seconds.
struct BalanceTotals {
  GlobalIndex n_repartitions = 0;
  GlobalIndex n_moved = 0;  ///< particles, by changes of maps
  double seconds = 0.0;     ///< of wall time: counting, deciding, changing
};

/// Keeps a solver's partition as [partition] of the scene says.
class Balancer {
 public:
  /// `cost`: of an earlier run, or the default; `step`: the number of steps made already. Both references must outlive the
  /// balancer.
  Balancer(const Comm& comm, const PartitionSettings& settings, CostModel cost, GlobalIndex step);

  /// To be called after each step, with its number. Collective.
  void after_step(Solver& solver, GlobalIndex step);

  /// What steps cost, as measured so far, smoothed.
  const CostModel& cost() const { return cost_; }
  const BalanceTotals& totals() const { return totals_; }

 private:
  /// Sums over the steps of this rank.
  struct Clock {
    double particles = 0.0, nodes = 0.0;  ///< s in what goes over particles (beside stress updates) and over nodes
    std::vector<double> materials;        ///< s in the stress updates
  };
  static Clock read_clock(const Solver& solver);
  void measure(const Solver& solver, const TileCensus& census, GlobalIndex step);
  std::optional<Partition> next_partition(const Solver& solver, const TileCensus& census, bool forced, GlobalIndex step);
  void change(Solver& solver, Partition partition);

  const Comm& comm_;
  const PartitionSettings& settings_;
  CostModel cost_;
  bool measured_ = false;
  ChangeCost change_;
  Clock last_clock_;
  GlobalIndex last_look_, last_change_;  ///< step numbers
  GlobalIndex busiest_moves_ = 0;        ///< in the change that has been decided; the root's
  BalanceTotals totals_;
};

}  // namespace bulkley
