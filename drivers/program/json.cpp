#include "program/json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "io/status/json.hpp"

namespace bulkley {

JsonObject& JsonObject::add(std::string key, const std::string& value) {
  entries_.push_back({std::move(key), json_text(value), {}});
  return *this;
}

JsonObject& JsonObject::add(std::string key, double value) {
  entries_.push_back({std::move(key), std::isfinite(value) ? fmt::format("{:.6g}", value) : json_text(value), {}});
  return *this;
}

JsonObject& JsonObject::add(std::string key, GlobalIndex value) {
  entries_.push_back({std::move(key), fmt::format("{}", value), {}});
  return *this;
}

JsonObject& JsonObject::add(std::string key, const JsonObject& value) {
  entries_.push_back({std::move(key), {}, {value}});
  return *this;
}

JsonObject& JsonObject::add(std::string key, const std::vector<JsonObject>& values) {
  entries_.push_back({std::move(key), {}, values, true});
  return *this;
}

std::string JsonObject::text(int indent) const {
  const std::string inner(static_cast<std::size_t>(indent) + 2, ' ');
  std::string lines;
  for (const Entry& entry : entries_) {
    std::string value = entry.value;
    if (entry.is_list) {
      for (const JsonObject& object : entry.objects)
        value += fmt::format("{}\n{}  {}", value.empty() ? "" : ",", inner, object.text(indent + 4));
      value = fmt::format("[{}\n{}]", value, inner);
    } else if (!entry.objects.empty()) {
      value = entry.objects.front().text(indent + 2);
    }
    lines += fmt::format("{}\n{}{}: {}", lines.empty() ? "" : ",", inner, json_text(entry.key), value);
  }
  return fmt::format("{{{}\n{}}}", lines, std::string(static_cast<std::size_t>(indent), ' '));
}

double json_number(std::string_view text, std::string_view key) {
  const std::string quoted = fmt::format("\"{}\":", key);
  const std::size_t at = text.find(quoted);
  if (at == std::string_view::npos) return std::numeric_limits<double>::quiet_NaN();
  const std::string rest(text.substr(at + quoted.size(), 40));
  char* end = nullptr;
  const double value = std::strtod(rest.c_str(), &end);
  return end == rest.c_str() ? std::numeric_limits<double>::quiet_NaN() : value;
}

}  // namespace bulkley
