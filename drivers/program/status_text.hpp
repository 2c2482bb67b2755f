#pragma once
// Progress of a run as text: on several lines, in one line, in a table of several, and as JSON. Not collective.

#include <string>
#include <vector>

#include "io/files/json_text.hpp"
#include "program/run_figures.hpp"
#include "program/run_folder.hpp"

namespace bulkley {

/// A folder and what was read of it.
struct RunView {
  explicit RunView(const std::string& folder) : run(read_run_folder(folder)), figures(figures_of(run)) {}
  RunFolder run;
  RunFigures figures;

  /// "running", "silent", "stopped", ...
  std::string state() const { return silent() ? "silent" : run.state; }
  bool silent() const { return run.silent(figures.seconds_per_step); }
};

/// Texts that the report and the lines of status share.
std::string progress_text(const RunView& view);
std::string rate_text(const RunView& view);
std::string left_text(const RunView& view);
std::string limiter_text(const RunView& view);
std::string trials_text(const RunView& view);
/// Of an implicit pressure, and of J; empty where no row contains it.
std::string volume_text(const RunView& view);
std::string particles_text(const RunView& view);
std::string energy_text(const RunView& view);
/// What came in, where it went, and what is left of the sum; empty for a table without an energy budget.
std::string received_text(const RunView& view);
std::string losses_text(const RunView& view);
std::string closure_text(const RunView& view);
std::string balance_text(const RunView& view);
std::string disk_text(const RunView& view);
std::string checkpoint_text(const RunView& view);
/// A hint on a run that has not finished: one sentence, or empty.
std::string advice_text(const RunView& view);

/// Lines about one run, each ended by a line break.
std::string status_lines(const RunView& view);
/// One line about one run, without a line break: for logs.
std::string status_line(const RunView& view);
/// A line of names and one a run.
std::string status_table(const std::vector<RunView>& views);
Json status_json(const RunView& view);

}  // namespace bulkley
