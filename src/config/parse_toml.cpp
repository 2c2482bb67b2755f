#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>

#include "bulkley/base/error.hpp"
#include "bulkley/config/toml.hpp"
#include "config/nearest.hpp"
#include "config/text_limits.hpp"

namespace bulkley::config {
namespace {

Place place_of(const toml::source_region& region, const std::string& source) {
  return {source, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

bool comes_first(const Value& a, const Value& b) {
  return std::pair(a.key_place.line, a.key_place.column) < std::pair(b.key_place.line, b.key_place.column);
}

Value convert(const toml::node& node, const std::string& source, const std::string& path) {
  Value v;
  if (const auto* boolean = node.as_boolean()) {
    v = make_boolean(boolean->get());
  } else if (const auto* integer = node.as_integer()) {
    v = make_integer(integer->get());
  } else if (const auto* number = node.as_floating_point()) {
    v = make_number(number->get());
  } else if (const auto* text = node.as_string()) {
    v = make_text(text->get());
  } else if (const auto* list = node.as_array()) {
    v.kind = Kind::list;
    for (const toml::node& item : *list)
      v.items.push_back(convert(item, source, child_path(path, std::to_string(v.items.size()))));
  } else if (const auto* table = node.as_table()) {
    v.kind = Kind::table;
    for (const auto& [key, entry] : *table) {
      Value item = convert(entry, source, child_path(path, std::string(key.str())));
      item.key = std::string(key.str());
      item.key_place = place_of(key.source(), source);
      v.items.push_back(std::move(item));
    }
    // The parser sorts keys by name; the order of the file numbers the materials.
    std::stable_sort(v.items.begin(), v.items.end(), comes_first);
  } else {
    v.kind = Kind::date;
  }
  v.path = path;
  v.place = place_of(node.source(), source);
  return v;
}

/// The parser's remark in the words of our messages.
std::string reword(const std::string& remark) {
  if (const auto at = remark.find("cannot redefine existing "); at != std::string::npos) {
    const auto first = remark.find('\'', at), last = remark.rfind('\'');
    if (first == std::string::npos) return "a key is given twice: " + remark.substr(at);  // by a dotted key, without a name
    const std::string what = remark.find("existing table", at) != std::string::npos ? "table" : "key";
    return fmt::format("{} {} is given twice", what, remark.substr(first, last - first + 1));
  }
  constexpr std::string_view preamble = "Error while parsing ";
  const std::string detail = remark.starts_with(preamble) ? remark.substr(preamble.size()) : remark;
  std::string sentence = fmt::format("this is not valid TOML: {}", detail);
  // A text without quotes is taken for a boolean, a number or nothing known.
  for (const char* start : {"value", "boolean", "floating-point"})
    if (detail.starts_with(start)) return sentence + " (a text needs quotes, a number a digit on both sides of its point)";
  return sentence;
}

/// Gives the whole tree of an override's value its place.
void set_place(Value& v, const std::string& path, const Place& place) {
  v.path = path;
  v.place = v.key_place = place;
  for (std::size_t i = 0; i < v.items.size(); ++i)
    set_place(v.items[i], child_path(path, v.is_table() ? v.items[i].key : std::to_string(i)), place);
}

/// "a.b.c", with TOML's quotes where a key holds a dot; empty if it is not a dotted key.
std::vector<std::string> split_path(const std::string& path) {
  std::vector<std::string> keys;
  try {
    const toml::table parsed = toml::parse(path + " = 0");
    for (const toml::node* node = &parsed; node->is_table();) {
      const toml::table& table = *node->as_table();
      if (table.size() != 1) return {};
      keys.emplace_back(table.begin()->first.str());
      node = &table.begin()->second;
    }
  } catch (const toml::parse_error&) {
    return {};
  }
  return keys;
}

Value override_value(const std::string& text) {
  try {
    const toml::table parsed = toml::parse("value = " + text);
    if (parsed.size() == 1) return convert(*parsed.get("value"), "", "");
  } catch (const toml::parse_error&) {
    // Bare words need no quotes on the command line.
  }
  return make_text(text);
}

/// The entry of a list that `key` names by its index or its `name`.
Value* find_in_list(Value& list, const std::string& key) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
  if (error == std::errc{} && end == key.data() + key.size())
    return index < list.items.size() ? &list.items[index] : nullptr;
  for (Value& item : list.items)
    if (const Value* name = item.find("name"); name && name->kind == Kind::text && name->text == key) return &item;
  return nullptr;
}

std::string entries_of(const Value& list) {
  std::vector<std::string> names;
  for (const Value& item : list.items)
    if (const Value* name = item.find("name"); name && name->kind == Kind::text) names.push_back(name->text);
  const std::string named = names.empty() ? "" : fmt::format(" ({})", quoted_list(names, '\''));
  return fmt::format("{} {}{}", list.items.size(), list.items.size() == 1 ? "entry" : "entries", named);
}

}  // namespace

Value parse_toml(const std::string& text, const std::string& file_name) {
  if (const auto fault = size_fault(text))
    throw UsageError(Place{file_name, fault->line, fault->column}.text() + ": " + fault->sentence);
  try {
    return convert(toml::parse(std::string_view(text)), file_name, "");
  } catch (const toml::parse_error& error) {
    throw UsageError(place_of(error.source(), file_name).text() + ": " +
                     printable(reword(std::string(error.description()))));
  }
}

void apply_override(Value& root, const std::string& assignment, Faults& faults) {
  const Place place{printable("--set " + assignment), 0, 0};
  if (!is_utf8(assignment) || size_fault(assignment)) {
    faults.add(place, "this override is no UTF-8 text, too long or nested too deeply");
    return;
  }
  const auto equals = assignment.find('=');
  const std::vector<std::string> keys =
      equals == std::string::npos ? std::vector<std::string>{} : split_path(assignment.substr(0, equals));
  if (keys.empty()) {
    faults.add(place, "an override has the form key.path=value");
    return;
  }
  Value* at = &root;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    Value* next = nullptr;
    if (at->is_list()) {
      next = find_in_list(*at, keys[k]);
      if (!next) {
        faults.add(place, fmt::format("'{}' has no entry '{}'; it has {}", at->path, keys[k], entries_of(*at)));
        return;
      }
    } else if (at->is_table()) {
      next = at->find(keys[k]);
      if (!next) {
        Value table = make_table();
        table.key = keys[k];
        set_place(table, child_path(at->path, keys[k]), place);
        at->items.push_back(std::move(table));
        next = &at->items.back();
      }
    } else {
      faults.add(place, fmt::format("'{}' is {}, it has no entry '{}'", at->path, in_words(*at), keys[k]));
      return;
    }
    at = next;
  }
  const std::string key = at->key, path = at->path;
  *at = override_value(assignment.substr(equals + 1));
  set_place(*at, path, place);
  at->key = key;
}

}  // namespace bulkley::config
