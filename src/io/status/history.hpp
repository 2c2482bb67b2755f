#pragma once
// history.csv: one row of scalars every few steps, for plotting.

#include <string>
#include <variant>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "io/files/text_file.hpp"

namespace bulkley {

using HistoryValue = std::variant<GlobalIndex, double, std::string>;

/// The open table; the root writes. Doubles are written in the fewest digits that read back to the same bits.
class History {
 public:
  /// Opens `folder`/history.csv. `columns`: names with units, "step" first. `restart_step` -1 begins a new table; otherwise
  /// rows beyond that step, and a last row cut short, are removed from the one that is there (if any). Throws RunError, also
  /// when the table that is there has other columns. Collective.
  History(const Comm& comm, const std::string& folder, std::vector<std::string> columns, GlobalIndex restart_step);

  /// Appends a row and hands it to the operating system at once. One value a column; the root's count. Throws RunError on
  /// every rank. Collective.
  void write(const Comm& comm, const std::vector<HistoryValue>& row);

  /// Flushes the rows to disk, so that a restart from a checkpoint written after this finds all rows before it. Throws
  /// RunError on every rank. Collective.
  void sync(const Comm& comm);

 private:
  std::string path_;
  std::size_t n_columns_ = 0;
  GrowingFile file_;
};

}  // namespace bulkley
