#pragma once
// What a measurement gives: named columns of numbers, and sentences about them.

#include <string>
#include <vector>

namespace bulkley::rheometer {

struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;

  /// Values of a column. Requires that there is one of that name.
  std::vector<double> column(const std::string& name) const;
  bool has(const std::string& name) const;
};

/// The table and what the reader should know about it, one sentence each.
struct Measurement {
  Table table;
  std::vector<std::string> remarks;
};

/// The row under construction, so that a name and its value are next to each other. The first row of a table names its
/// columns; later rows must have the same.
class Row {
 public:
  Row& add(const std::string& name, double value);
  void append_to(Table& table) const;

 private:
  std::vector<std::string> names_;
  std::vector<double> values_;
};

/// A header line and one line a row, with the digits that give every double again to 1e-12.
std::string csv_text(const Table& table);

}  // namespace bulkley::rheometer
