#include "rheometer/number_list.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "base/text.hpp"
#include "bulkley/base/error.hpp"

namespace bulkley::rheometer {

namespace {

[[noreturn]] void fault(const std::string& option, const std::string& text, const std::string& sentence) {
  throw UsageError(fmt::format("{} '{}': {}", option, text, sentence));
}

std::vector<double> logarithmic(const std::vector<std::string>& parts, const std::string& text, const std::string& option) {
  constexpr int largest_count = 10000;
  const auto lower = parse_number(parts[0]), upper = parse_number(parts[1]), count = parse_number(parts[2]);
  if (!lower || !upper || !count) fault(option, text, "LOWER:UPPER:COUNT must be three numbers, like 0.01:100:20");
  if (*lower <= 0.0 || *upper <= *lower) fault(option, text, "in LOWER:UPPER:COUNT, 0 < LOWER < UPPER");
  if (*count < 2.0 || *count > largest_count || *count != std::floor(*count))
    fault(option, text, fmt::format("in LOWER:UPPER:COUNT, COUNT is a whole number from 2 to {}", largest_count));
  const int n = static_cast<int>(*count);
  std::vector<double> values;
  for (int k = 0; k < n; ++k) values.push_back(*lower * std::pow(*upper / *lower, k / (n - 1.0)));
  values.back() = *upper;
  return values;
}

}  // namespace

std::optional<double> parse_number(const std::string& text) {
  // strtod would also take leading blanks, "inf", "nan" and hexadecimals.
  if (text.empty() || text.find_first_not_of("0123456789+-.eE") != std::string::npos) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (*end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<double> parse_number_list(const std::string& text, const std::string& option, bool zero_allowed) {
  if (const auto parts = split(text, ':'); parts.size() == 3) return logarithmic(parts, text, option);
  std::vector<double> values;
  for (const std::string& part : split(text, ',')) {
    const auto value = parse_number(part);
    if (!value) fault(option, text, "neither numbers with commas between them, like 1,2,5, nor LOWER:UPPER:COUNT");
    if (*value < 0.0 || (*value == 0.0 && !zero_allowed))
      fault(option, text, fmt::format("{} is not {} 0", part, zero_allowed ? "at least" : "above"));
    values.push_back(*value);
  }
  return values;
}

Range parse_range(const std::string& text, const std::string& option) {
  const auto parts = split(text, ':');
  const auto lower = parse_number(parts.front()), upper = parse_number(parts.back());
  if (parts.size() != 2 || !lower || !upper || *lower < 0.0 || *upper <= *lower)
    fault(option, text, "not LOWER:UPPER with 0 <= LOWER < UPPER");
  return {*lower, *upper};
}

}  // namespace bulkley::rheometer
