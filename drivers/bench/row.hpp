#pragma once
// One number of the suite and its bound: a line of the table and an object of the JSON.

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/bounds.hpp"
#include "io/files/json_text.hpp"

namespace bulkley {

struct Row {
  std::string part, name;
  double value = std::numeric_limits<double>::quiet_NaN();
  std::string unit = {};
  Bound bound = {};
  std::string note = {};
  Json details = Json::object();
  std::string skip_reason = {};  ///< "skipped" or "failed", where there is no value; the note gives the reason
};

/// A row with the reason why there is no value.
Row row_without_value(std::string part, std::string name, std::string skip_reason, std::string why);

/// How far the figure is beyond its bound: above 1 is too far; NaN where there is no bound or no value.
double excess(const Row& row);

std::string row_heading();
std::string row_line(const Row& row);
Json describe(const Row& row);

}  // namespace bulkley
