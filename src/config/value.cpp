#include "bulkley/config/value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bulkley/base/error.hpp"
#include "bulkley/config/toml.hpp"

namespace bulkley::config {

std::string Place::text() const { return line > 0 ? fmt::format("{}:{}:{}", source, line, column) : source; }

const Value* Value::find(std::string_view name) const {
  for (const Value& item : items)
    if (item.key == name) return &item;
  return nullptr;
}

Value* Value::find(std::string_view name) { return const_cast<Value*>(std::as_const(*this).find(name)); }

Value make_boolean(bool value) {
  Value v;
  v.kind = Kind::boolean;
  v.boolean = value;
  return v;
}

Value make_integer(std::int64_t value) {
  Value v;
  v.kind = Kind::integer;
  v.integer = value;
  v.number = static_cast<double>(value);
  return v;
}

Value make_number(double value) {
  Value v;
  v.kind = Kind::number;
  v.number = value;
  return v;
}

Value make_text(std::string value) {
  Value v;
  v.kind = Kind::text;
  v.text = std::move(value);
  return v;
}

Value make_list(std::vector<Value> items) {
  Value v;
  v.kind = Kind::list;
  v.items = std::move(items);
  return v;
}

Value make_table() {
  Value v;
  v.kind = Kind::table;
  return v;
}

void add_entry(Value& table, const std::string& key, Value value, const std::string& comment) {
  if (value.kind == Kind::none) return;
  value.key = key;
  if (!comment.empty()) value.comment = comment;
  table.items.push_back(std::move(value));
}

std::string in_words(const Value& value) {
  switch (value.kind) {
    case Kind::none:
      return "nothing";
    case Kind::boolean:
      return "the boolean " + print_inline(value);
    case Kind::integer:
      return "the integer " + print_inline(value);
    case Kind::number:
      return "the number " + print_inline(value);
    case Kind::text:
      return "the text " + print_inline(value);
    case Kind::list:
      return "a list";
    case Kind::table:
      return "a table";
    case Kind::date:
      return "a date or time";
  }
  return "";
}

std::string table_name(const std::string& path) { return "[" + path + "]"; }

std::string in_table(const std::string& path) { return path.empty() ? "at the top level" : "in " + table_name(path); }

std::string child_path(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

void Faults::add(const Place& place, const std::string& sentence) { faults_.push_back({place, sentence}); }

void Faults::throw_if_any() const {
  if (faults_.empty()) return;
  std::vector<Fault> sorted = faults_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Fault& a, const Fault& b) {
    return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
  });
  std::string text;
  for (const Fault& fault : sorted)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "\n", fault.place.text(), fault.sentence);
  throw UsageError(text);
}

}  // namespace bulkley::config
