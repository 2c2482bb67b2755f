#include "rheometer/table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "bulkley/base/error.hpp"

namespace bulkley::rheometer {

bool Table::has(const std::string& name) const { return std::find(columns.begin(), columns.end(), name) != columns.end(); }

std::vector<double> Table::column(const std::string& name) const {
  const auto index = std::find(columns.begin(), columns.end(), name) - columns.begin();
  std::vector<double> values;
  for (const std::vector<double>& row : rows) values.push_back(row.at(static_cast<std::size_t>(index)));
  return values;
}

Row& Row::add(const std::string& name, double value) {
  names_.push_back(name);
  values_.push_back(value);
  return *this;
}

void Row::append_to(Table& table) const {
  if (table.rows.empty()) table.columns = names_;
  BULKLEY_ASSERT(table.columns == names_);
  table.rows.push_back(values_);
}

std::string csv_text(const Table& table) {
  std::string text = fmt::format("{}\n", fmt::join(table.columns, ","));
  for (const std::vector<double>& row : table.rows) text += fmt::format("{:.12g}\n", fmt::join(row, ","));
  return text;
}

}  // namespace bulkley::rheometer
