#pragma once
// When the particles get a new map: measures what steps cost, foresees what another map would save, and changes it if that
// pays.

#include <optional>
#include <string>
#include <utility>

#include "balance/partition.hpp"
#include "balance/partition_settings.hpp"
#include "bulkley/parallel/comm.hpp"

namespace bulkley {

class Solver;

/// What looking at the balance and changing maps costs, s; measured as a run goes on.
struct ChangeCost {
  double look = 1e-3;      ///< to count the particles of tiles and to decide
  double rebuild = 1e-3;   ///< of pools and exchange
  double particle = 1e-6;  ///< of each particle that the busiest rank sends or receives
  double tile = 1e-5;      ///< of making a whole new map, for each loaded tile
};

/// What worthwhile_change has found.
struct Change {
  std::optional<Partition> partition;  ///< none: the present one stays
  bool whole = false;                  ///< a whole new map, not one with few tiles moved
  double making = 0.0;                 ///< s of wall time that a whole new map took, whether it is taken or not
};

/// The partition that saves more than it costs, if there is one: over the next `horizon` steps, the predicted time of the
/// slowest rank under `present` less that under the new map must exceed the cost of the change, and be at least 2 % of the
/// former (so that noise in the measured costs moves nothing). Candidates are `present` with few tiles moved (rebalanced),
/// and, where that leaves enough to be gained, a whole new map by `automatic`. `fresh_exchange`: predicted_exchange when the
/// last whole map was new, s; what another may come down to. Not collective.
Change worthwhile_change(const GridGeometry& grid, const TileLoad& load, const Partition& present, const CostModel& cost,
                         const ChangeCost& change, double horizon, double fresh_exchange);

/// What balancing has done so far; the same on every rank but for seconds.
struct BalanceTotals {
  GlobalIndex n_repartitions = 0;
  GlobalIndex n_moved = 0;  ///< particles, by changes of maps
  double seconds = 0.0;     ///< of wall time: counting, deciding, changing
};

/// Keeps a solver's partition as [partition] of the scene says.
class Balancer {
 public:
  /// `cost`: of an earlier run, or the default; `step`: the number of steps made already. `comm` must outlive the balancer.
  Balancer(const Comm& comm, const PartitionSettings& settings, CostModel cost, GlobalIndex step);

  /// To be called after each step, with its number. Collective.
  void after_step(Solver& solver, GlobalIndex step);

  /// What steps cost, as measured so far, smoothed.
  const CostModel& cost() const { return cost_; }
  const BalanceTotals& totals() const { return totals_; }
  /// The first warning about a partition since the last call, on the root; no second one in a run.
  std::string take_warning() { return std::exchange(warning_, {}); }

 private:
  /// Sums over the steps of this rank.
  struct Clock {
    double particles = 0.0, nodes = 0.0;  ///< s in what goes over particles (beside stress updates) and over nodes
    std::vector<double> materials;        ///< s in the stress updates
  };
  /// What the root tells the others after a look.
  struct Verdict {
    GlobalIndex changes = 0;        ///< whether there is a new partition
    GlobalIndex patience = 0;       ///< see patience_
    GlobalIndex pause = 0;          ///< see pause_
    GlobalIndex busiest_moves = 0;  ///< particles that the busiest rank sends or receives in the change
  };
  static Clock read_clock(const Solver& solver);
  bool due(const Solver& solver, GlobalIndex step);
  void measure(const Solver& solver, const TileCensus& census, GlobalIndex step);
  Verdict decide(const Solver& solver, const TileCensus& census, bool forced, GlobalIndex step,
                 std::optional<Partition>& next);
  void change(Solver& solver, Partition partition, GlobalIndex busiest_moves);

  const Comm& comm_;
  PartitionSettings settings_;
  CostModel cost_;
  bool measured_ = false;
  ChangeCost change_;
  double fresh_exchange_ = -1.0;  ///< s; the root's. Below zero: not known yet
  Clock last_clock_;
  GlobalIndex last_look_, last_change_;  ///< step numbers
  GlobalIndex share_then_ = -1;  ///< particles of the fullest rank after the last change, or of one if all had as many
  GlobalIndex lost_ = 0;         ///< since then: sum over steps of how many more it had
  GlobalIndex patience_ = 0;     ///< what it may come to before the next look: the price of look and change, in particles
  GlobalIndex pause_ = 0;        ///< steps to the next look in any case
  BalanceTotals totals_;
  std::string warning_;
  bool has_warned_ = false;
};

}  // namespace bulkley
