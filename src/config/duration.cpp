#include "config/duration.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley {
namespace {

double seconds_per(char unit) {
  switch (unit) {
    case 'd':
      return 86400.0;
    case 'h':
      return 3600.0;
    case 'm':
      return 60.0;
    case 's':
      return 1.0;
    default:
      return 0.0;
  }
}

}  // namespace

double parse_duration(const std::string& text) {
  const auto refuse = [&]() -> UsageError {
    return UsageError(
        fmt::format("'{}' is not a duration; write for example 90s, 10m, 1h55m, 2d or a number of seconds", text));
  };
  if (text.empty()) throw refuse();
  double total = 0.0;
  double previous_unit = INFINITY;  // units come in falling order, each once
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    double count = 0.0;
    const auto [after, error] = std::from_chars(at, end, count);
    if (error != std::errc{} || !std::isfinite(count) || !(count >= 0.0) || std::signbit(count)) throw refuse();
    if (after == end && at == text.data()) return count;
    const double unit = after == end ? 0.0 : seconds_per(*after);
    if (unit == 0.0 || unit >= previous_unit) throw refuse();
    total += count * unit;
    previous_unit = unit;
    at = after + 1;
  }
  return total;
}

std::string duration_text(double seconds) {
  if (!(seconds >= 0.0) || seconds > 1e15) return fmt::format("{} s", seconds);
  auto milliseconds = static_cast<long long>(std::llround(seconds * 1000.0));
  std::string text;
  for (const char unit : {'d', 'h', 'm'}) {
    const auto length = static_cast<long long>(seconds_per(unit) * 1000.0);
    if (milliseconds >= length) text += fmt::format("{}{}", milliseconds / length, unit);
    milliseconds %= length;
  }
  if (milliseconds > 0 || text.empty()) text += fmt::format("{}s", static_cast<double>(milliseconds) / 1000.0);
  return text;
}

}  // namespace bulkley
