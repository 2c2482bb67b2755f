#pragma once
// What one key accepts; messages and the reference page are made from it.

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace bulkley::config {

/// An interval of allowed numbers.
struct Range {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool lower_excluded = false;
  bool upper_excluded = false;

  bool contains(double value) const;
  bool bounded() const;
  std::string words() const;    ///< "greater than 0 and at most 0.5"
  std::string symbols() const;  ///< "> 0, <= 0.5"
};

constexpr Range at_least(double lower) { return {.lower = lower}; }
constexpr Range above(double lower) { return {.lower = lower, .lower_excluded = true}; }
constexpr Range between(double lower, double upper) { return {.lower = lower, .upper = upper}; }
constexpr Range above_to(double lower, double upper) { return {.lower = lower, .upper = upper, .lower_excluded = true}; }
constexpr Range strictly_between(double lower, double upper) {
  return {.lower = lower, .upper = upper, .lower_excluded = true, .upper_excluded = true};
}

struct Rule {
  std::string about;                       ///< one sentence
  std::string unit = "";                   ///< "" for what has none
  Range range = {};                        ///< numbers and integers
  std::vector<std::int64_t> choices = {};  ///< integers; empty: any
  std::vector<std::string> names = {};     ///< texts, lists of texts; empty: any
  bool required = false;
  bool duration = false;          ///< a number of seconds that may also be written "1h30m"
  bool may_be_infinite = false;   ///< where a program sets it; scenes hold finite numbers only
  std::string default_text = "";  ///< shown on the reference page instead of the struct's default
};

/// What is wrong with a number that a program gave, as one sentence: not given (NaN), out of range, infinite; empty when nothing
/// is. Not collective.
std::optional<std::string> number_fault(const std::string& name, double value, const Range& range, bool may_be_infinite);

/// A row of the reference page.
struct KeyText {
  std::string name, type, unit, default_text, allowed, about;
  bool required = false;
  std::string old_name = "";  ///< accepted with a warning, not on the page; "" for most keys
};

/// A section of the reference page.
struct TableText {
  std::string title;  ///< "[time]"
  std::string about;
  std::vector<KeyText> keys;
};

/// The sections as Markdown.
std::string print_reference(const std::vector<TableText>& tables);

}  // namespace bulkley::config
