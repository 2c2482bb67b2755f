#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "bulkley/config/toml.hpp"

namespace bulkley::config {
namespace {

std::string key_text(const std::string& key) {
  const auto bare = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  return !key.empty() && std::all_of(key.begin(), key.end(), bare) ? key : toml_string(key);
}

/// The shortest digits that give back the same bits, marked as a floating-point number.
std::string number_text(double number) {
  if (std::isnan(number)) return "nan";
  if (std::isinf(number)) return number > 0 ? "inf" : "-inf";
  std::string text = fmt::format("{}", number);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

bool all_tables(const Value& value) {
  return !value.items.empty() &&
         std::all_of(value.items.begin(), value.items.end(), [](const Value& v) { return v.is_table(); });
}

void print_entries(const Value& table, std::string& out) {
  for (const Value& entry : table.items) {
    out += fmt::format("{} = {}", key_text(entry.key), print_inline(entry));
    out += entry.comment.empty() ? "\n" : fmt::format("  # {}\n", entry.comment);
  }
}

void print_section(const std::string& header, const Value& table, std::string& out) {
  out += fmt::format("\n{}{}\n", header, table.comment.empty() ? "" : "  # " + table.comment);
  print_entries(table, out);
}

}  // namespace

std::string print_inline(const Value& value) {
  std::string result;
  switch (value.kind) {
    case Kind::none:
      return "";
    case Kind::date:
      return "a date";
    case Kind::boolean:
      return value.boolean ? "true" : "false";
    case Kind::integer:
      return fmt::format("{}", value.integer);
    case Kind::number:
      return number_text(value.number);
    case Kind::text:
      return toml_string(value.text);
    case Kind::list:
      for (const Value& item : value.items) result += (result.empty() ? "" : ", ") + print_inline(item);
      return "[" + result + "]";
    case Kind::table:
      for (const Value& item : value.items)
        result += fmt::format("{}{} = {}", result.empty() ? "" : ", ", key_text(item.key), print_inline(item));
      return result.empty() ? "{}" : "{ " + result + " }";
  }
  return result;
}

std::string print_toml(const Value& root) {
  std::string out;
  Value plain = make_table();
  for (const Value& entry : root.items)
    if (!entry.is_table() && !(entry.is_list() && all_tables(entry))) plain.items.push_back(entry);
  print_entries(plain, out);
  for (const Value& entry : root.items) {
    const std::string name = key_text(entry.key);
    if (entry.is_list() && all_tables(entry)) {
      for (const Value& item : entry.items) print_section("[[" + name + "]]", item, out);
    } else if (entry.is_table() && all_tables(entry)) {
      for (const Value& item : entry.items) print_section("[" + name + "." + key_text(item.key) + "]", item, out);
    } else if (entry.is_table()) {
      print_section("[" + name + "]", entry, out);
    }
  }
  return out;
}

}  // namespace bulkley::config
