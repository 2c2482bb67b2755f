#include "bench/row.hpp"

#include <fmt/format.h>

#include <cmath>

namespace bulkley {

namespace {

constexpr const char* layout = "{:<8}{:<44}{:>9} {:<14}{:<9}{:<9}{}";

std::string verdict(const Row& row) {
  if (!row.skip_reason.empty()) return row.skip_reason;
  if (std::isnan(row.bound.limit)) return "-";
  return excess(row) <= 1.0 ? "pass" : "over";
}

std::string bound_text(const Bound& bound) {
  if (std::isnan(bound.limit)) return "";
  return fmt::format("{} {:g}", bound.sense == Sense::at_most ? "<=" : ">=", bound.limit);
}

}  // namespace

Row row_without_value(std::string part, std::string name, std::string skip_reason, std::string why) {
  return {.part = std::move(part), .name = std::move(name), .note = std::move(why), .skip_reason = std::move(skip_reason)};
}

double excess(const Row& row) {
  return row.bound.sense == Sense::at_most ? row.value / row.bound.limit : row.bound.limit / row.value;
}

std::string row_heading() { return fmt::format(layout, "part", "figure", "value", "unit", "bound", "verdict", "note"); }

std::string row_line(const Row& row) {
  const std::string value = std::isnan(row.value) ? "-" : fmt::format("{:.4g}", row.value);
  return fmt::format(layout, row.part, row.name, value, row.unit, bound_text(row.bound), verdict(row), row.note);
}

Json describe(const Row& row) {
  return {{"part", row.part},
          {"name", row.name},
          {"value", rounded(row.value)},
          {"unit", row.unit},
          {"bound", rounded(row.bound.limit)},
          {"sense", row.bound.sense == Sense::at_most ? "at_most" : "at_least"},
          {"excess", rounded(excess(row))},
          {"verdict", verdict(row)},
          {"note", row.note},
          {"details", row.details}};
}

}  // namespace bulkley
