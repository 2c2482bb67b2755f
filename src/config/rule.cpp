#include "bulkley/config/rule.hpp"

#include <fmt/format.h>

#include <cmath>

namespace bulkley::config {
namespace {

/// Joins the two ends of an interval, each written by `lower` and `upper` where it is bounded.
std::string ends(const Range& range, const char* lower, const char* upper, const char* between) {
  std::string text;
  if (std::isfinite(range.lower)) text += fmt::format("{} {}", lower, range.lower);
  if (std::isfinite(range.upper)) text += fmt::format("{}{} {}", text.empty() ? "" : between, upper, range.upper);
  return text;
}

/// A table cell of the reference page; a bar would end the cell.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

}  // namespace

bool Range::contains(double value) const {
  return (lower_excluded ? value > lower : value >= lower) && (upper_excluded ? value < upper : value <= upper);
}

bool Range::bounded() const { return std::isfinite(lower) || std::isfinite(upper); }

std::string Range::words() const {
  return ends(*this, lower_excluded ? "greater than" : "at least", upper_excluded ? "less than" : "at most", " and ");
}

std::string Range::symbols() const { return ends(*this, lower_excluded ? ">" : ">=", upper_excluded ? "<" : "<=", ", "); }

std::optional<std::string> number_fault(const std::string& name, double value, const Range& range, bool may_be_infinite) {
  const std::string words = range.words();
  if (std::isnan(value)) return name + " is not given" + (words.empty() ? "" : "; it must be " + words);
  if (!range.contains(value)) return fmt::format("{} = {} must be {}", name, value, words);
  if (std::isinf(value) && !may_be_infinite) return fmt::format("{} = {} must be finite", name, value);
  return std::nullopt;
}

std::string print_reference(const std::vector<TableText>& tables) {
  std::string page;
  for (const TableText& table : tables) {
    page += fmt::format("## {}\n\n{}\n\n", table.title, table.about);
    page += "| Key | Type | Unit | Default | Allowed | Meaning |\n|---|---|---|---|---|---|\n";
    for (const KeyText& key : table.keys)
      page += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.name, key.type, key.unit,
                          key.required ? "**required**" : cell(key.default_text), cell(key.allowed), cell(key.about));
    page += "\n";
  }
  if (!page.empty()) page.pop_back();
  return page;
}

}  // namespace bulkley::config
