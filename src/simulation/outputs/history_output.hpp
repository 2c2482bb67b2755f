#pragma once
// Rows of history.csv.

#include "io/status/history.hpp"
#include "simulation/outputs/output.hpp"

namespace bulkley {

class HistoryOutput : public Output {
 public:
  HistoryOutput(Run& run, GlobalIndex restart_step);  ///< Collective.
  bool is_due(const Run& run, const Occasion& occasion) const override;
  void write(Run& run) override;
  void make_durable(Run& run) override { history_.sync(run.comm); }

 private:
  History history_;
  GlobalIndex row_step_;             ///< of the last row
  double row_stepping_ = 0.0;        ///< RunClock::stepping at the last row, s
  std::vector<double> gauge_areas_;  ///< m^2
};

}  // namespace bulkley
