#include "io/status/json.hpp"

#include <fmt/format.h>

#include <cmath>

namespace bulkley {

std::string json_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (code < 0x20)
      quoted += fmt::format("\\u{:04x}", code);
    else
      quoted += c;
  }
  return quoted + "\"";
}

std::string json_text(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

}  // namespace bulkley
