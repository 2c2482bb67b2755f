#pragma once
// What steps, imbalance checks and changes of maps cost.

#include <vector>

#include "balance/map_change.hpp"
#include "bulkley/parallel/comm.hpp"

namespace bulkley {

class Solver;

/// Where costs come from: this run's clock; or they stay as they were given, so that what is decided by them is decided by
/// numbers of particles alone and does not depend on the machine.
enum class CostSource { clock, given };

/// Measures costs as a run continues, smoothed: single measurements are noisy.
class CostMeter {
 public:
  /// `steps`: of an earlier run, or the default.
  explicit CostMeter(CostModel steps = {}, CostSource source = CostSource::clock);

  /// `n_steps` have been made since the last call, or since the start of `solver`. Collective.
  void after_steps(const Comm& comm, const Solver& solver, const TileCensus& census, GlobalIndex n_steps);
  /// An imbalance check took `seconds`.
  void after_check(double seconds);
  /// A whole new map took the root `seconds` for each loaded tile.
  void after_whole_map(double seconds);
  /// A change of maps took `seconds`, `rebuild` of them for pools and exchange; no rank sent or received more than
  /// `busiest_moves` particles, 0: not known.
  void after_change(double seconds, double rebuild, GlobalIndex busiest_moves);

  const CostModel& steps() const { return steps_; }     ///< the same on every rank
  const ChangeCost& change() const { return change_; }  ///< as measured by this rank
  double check() const { return check_; }               ///< s, to count the particles of tiles and to decide; this rank's

 private:
  /// Sums over the steps of this rank.
  struct Clock {
    double particles = 0.0, nodes = 0.0;  ///< s in work on particles (without stress updates) and on nodes
    std::vector<double> materials;        ///< s in the stress updates
  };
  static Clock read_clock(const Solver& solver);

  CostSource source_;
  CostModel steps_;
  ChangeCost change_;
  double check_ = 1e-3;
  bool has_steps_, has_change_ = false;  ///< measured, or known from an earlier run: others are averaged in
  Clock last_;
};

}  // namespace bulkley
