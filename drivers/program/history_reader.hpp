#pragma once
// history.csv read row by row, also while a run writes it: an incomplete last row is ignored.

#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace bulkley {

/// Memory: one row and a buffer, for any size of the table. Not collective.
class HistoryReader {
 public:
  /// Opens `folder`/history.csv; a table that is not there has no columns and no rows.
  explicit HistoryReader(const std::string& folder);

  const std::vector<std::string>& columns() const { return columns_; }
  /// Index of a column; -1 if there is none.
  int find(std::string_view name) const;

  /// Goes on to at most `bytes` before the end, if that is ahead. True if rows were passed over.
  bool skip_to_last(std::size_t bytes);

  /// Reads the next row; false behind the last whole one.
  bool next();
  /// Cell of the row; empty in a column that is not there.
  std::string_view text(int column) const;
  /// The same as a number; NaN where it is none.
  double number(int column) const;

 private:
  bool next_line();
  bool split();

  std::vector<char> buffer_;
  std::ifstream file_;
  std::string line_;
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;
};

}  // namespace bulkley
