#pragma once
// When the particles get a new map: says when a partitioner is to be asked, and has the solver adopt what it proposes.

#include <memory>
#include <string>
#include <utility>

#include "balance/partition_settings.hpp"
#include "rebalance/cost_meter.hpp"
#include "rebalance/partitioner.hpp"

namespace bulkley {

/// What balancing has done so far; the same on every rank but for seconds.
struct BalanceTotals {
  GlobalIndex n_repartitions = 0;
  GlobalIndex n_moved = 0;  ///< particles, by changes of maps
  double seconds = 0.0;     ///< of wall time: counting, deciding, changing
};

/// Keeps a solver's partition as [partition] of the scene says.
class Balancer {
 public:
  /// `costs`: with those of an earlier run, or the default; `step`: the number of steps made already; `partitioner`: the
  /// one of the scene (make_partitioner), or another. `comm` must outlive the balancer.
  Balancer(const Comm& comm, const PartitionSettings& settings, CostMeter costs, GlobalIndex step);
  Balancer(const Comm& comm, const PartitionSettings& settings, CostMeter costs, GlobalIndex step,
           std::unique_ptr<Partitioner> partitioner);

  /// To be called after each step, with its number. Throws as Partitioner::propose does. Collective.
  void after_step(Solver& solver, GlobalIndex step);

  /// What steps cost, as measured so far, smoothed.
  const CostModel& cost() const { return costs_.steps(); }
  const BalanceTotals& totals() const { return totals_; }
  /// The first warning about a partition since the last call, on the root; no second one in a run.
  std::string take_warning() { return std::exchange(warning_, {}); }

 private:
  /// When the next check comes; the same on every rank.
  struct Decision {
    GlobalIndex budget = 0;    ///< see imbalance_budget_
    GlobalIndex interval = 0;  ///< see check_interval_
  };
  bool check_is_due(const Solver& solver, GlobalIndex step);
  PartitionProposal check(const Solver& solver, const TileCensus& census, bool forced, GlobalIndex step);
  Decision next_check(const TileCensus& census) const;
  void change(Solver& solver, Partition partition, GlobalIndex busiest_moves);

  const Comm& comm_;
  PartitionSettings settings_;
  CostMeter costs_;
  std::unique_ptr<Partitioner> partitioner_;
  GlobalIndex last_check_, last_change_;   ///< step numbers
  GlobalIndex reference_share_ = -1;       ///< particles of the most loaded rank after the last change; below zero: none yet
  GlobalIndex share_at_check_ = 0;         ///< particles of the most loaded rank at the last check
  GlobalIndex accumulated_imbalance_ = 0;  ///< since then: sum over steps of how many more particles it had
  GlobalIndex imbalance_budget_ = 0;       ///< above it a check is due: what check and change cost, in particles
  GlobalIndex check_interval_ = 0;         ///< steps after which a check is due in any case
  BalanceTotals totals_;
  std::string warning_;
  bool has_warned_ = false;
};

}  // namespace bulkley
