#include "program/human_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace bulkley {

std::string bytes_text(double bytes) {
  constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB", "PB"};
  std::size_t unit = 0;
  for (; bytes >= 999.5 && unit + 1 < std::size(units); ++unit) bytes /= 1000.0;
  if (unit == 0) return fmt::format("{:.0f} B", bytes);
  return fmt::format("{:.{}f} {}", bytes, bytes < 9.995 ? 2 : bytes < 99.95 ? 1 : 0, units[unit]);
}

std::string span_text(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  if (seconds < 0.9995) return fmt::format("{:.2g} s", std::max(seconds, 0.0));
  if (seconds < 59.5) return fmt::format("{:.0f} s", seconds);
  const auto whole = static_cast<long long>(std::min(std::round(seconds), 1e15));
  const long long days = whole / 86400, hours = whole / 3600 % 24, minutes = whole / 60 % 60;
  if (days > 0) return fmt::format("{}d{}h", days, hours);
  if (hours > 0) return fmt::format("{}h{:02}m", hours, minutes);
  return fmt::format("{}m{:02}s", minutes, whole % 60);
}

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : "?"; }

std::string count_text(double count) {
  if (!std::isfinite(count)) return "?";
  std::string text = fmt::format("{:.0f}", count);
  for (std::size_t at = text.size(); at > 3; text.insert(at, " ")) {
    at -= 3;
    if (text[at - 1] == '-') break;
  }
  return text;
}

std::string counted(double count, const std::string& noun) {
  return fmt::format("{} {}{}", count_text(count), noun, count == 1.0 ? "" : "s");
}

}  // namespace bulkley
