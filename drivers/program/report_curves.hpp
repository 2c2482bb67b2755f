#pragma once
// history.csv as plots: read once from end to end, however long, and thinned to what a page can show.

#include <string>
#include <vector>

#include "program/report_plot.hpp"
#include "program/run_folder.hpp"

namespace bulkley {

/// A curve of any number of points, added by ascending x, kept as about 1000: the smallest and the largest value of each of 500
/// equal parts of [lower, upper]; a shorter one is kept as it is.
class ThinnedCurve {
 public:
  ThinnedCurve(double lower, double upper) : lower_(lower), upper_(upper) {}
  void add(double x, double y);
  std::vector<PlotPoint> points() const;

 private:
  struct Bin {
    PlotPoint smallest, largest;
    bool used = false;
  };
  double lower_, upper_;
  std::vector<PlotPoint> first_;  // until there are too many
  std::vector<Bin> bins_;
  bool binned_ = false;
};

/// The plots of a run's history and the number of its rows.
struct HistoryPlots {
  std::vector<Plot> plots;
  GlobalIndex n_rows = 0;
  std::vector<PlotBar> limiters;  ///< per cent of the rows
};

/// Rows beyond `last_time` (s; from figures_of) are left for the next report. Not collective.
HistoryPlots history_plots(const RunFolder& run, double last_time);

}  // namespace bulkley
