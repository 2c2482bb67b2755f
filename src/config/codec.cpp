#include "bulkley/config/codec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"
#include "bulkley/config/keys.hpp"
#include "bulkley/config/toml.hpp"
#include "config/duration.hpp"
#include "config/nearest.hpp"

namespace bulkley::config {
namespace {

bool refuse_type(const Value& value, const std::string& wanted, Faults& faults) {
  faults.add(value.place, fmt::format("'{}' must be {}, not {}", value.path, wanted, in_words(value)));
  return false;
}

bool refuse_value(const Value& value, const std::string& wanted, Faults& faults) {
  faults.add(value.place, fmt::format("'{}' is {}; it must be {}", value.path, print_inline(value), wanted));
  return false;
}

/// Far beyond anything physical, and its third power is still a number.
constexpr double largest_number = 1e100;

bool is_number(const Value& value) { return value.kind == Kind::number || value.kind == Kind::integer; }

std::string choices_in_words(const std::vector<std::int64_t>& choices) {
  return fmt::format("one of {}", fmt::join(choices, ", "));
}

}  // namespace

bool read_number(const Value& value, const Rule& rule, double& out, Faults& faults) {
  Value seconds = value;
  if (rule.duration && value.kind == Kind::text) {
    try {
      seconds.number = parse_duration(value.text);
    } catch (const UsageError& error) {
      faults.add(value.place, fmt::format("'{}': {}", value.path, error.what()));
      return false;
    }
  } else if (!is_number(value)) {
    return refuse_type(value, rule.duration ? "a number of seconds or a duration such as \"10m\"" : "a number", faults);
  }
  const bool too_large = std::isfinite(seconds.number) && std::abs(seconds.number) > largest_number;
  if (!std::isfinite(seconds.number) || too_large || !rule.range.contains(seconds.number)) {
    const std::string first = !std::isfinite(seconds.number) ? "a finite number"
                              : too_large ? fmt::format("no larger than {:g} in magnitude", largest_number)
                                          : "";
    const std::string range = rule.range.words();
    return refuse_value(value, first + (first.empty() || range.empty() ? "" : ", ") + range, faults);
  }
  out = seconds.number;
  return true;
}

bool read_integer(const Value& value, const Rule& rule, std::int64_t lowest, std::int64_t highest, std::int64_t& out,
                  Faults& faults) {
  if (value.kind != Kind::integer) return refuse_type(value, "an integer", faults);
  if (!rule.choices.empty() && std::find(rule.choices.begin(), rule.choices.end(), value.integer) == rule.choices.end())
    return refuse_value(value, choices_in_words(rule.choices), faults);
  if (!rule.range.contains(value.number)) return refuse_value(value, rule.range.words(), faults);
  if (value.integer < lowest) return refuse_value(value, fmt::format("at least {}", lowest), faults);
  if (value.integer > highest) return refuse_value(value, fmt::format("at most {}", highest), faults);
  out = value.integer;
  return true;
}

bool read_boolean(const Value& value, bool& out, Faults& faults) {
  if (value.kind != Kind::boolean) return refuse_type(value, "true or false", faults);
  out = value.boolean;
  return true;
}

bool read_text(const Value& value, const Rule& rule, std::string& out, Faults& faults) {
  if (value.kind != Kind::text) return refuse_type(value, "text", faults);
  if (!rule.names.empty()) {
    std::size_t index = 0;
    if (!read_choice(value, rule.names, index, faults)) return false;
  }
  if (rule.required && value.text.empty()) return refuse_value(value, "a text of at least one letter", faults);
  out = value.text;
  return true;
}

bool read_texts(const Value& value, const Rule& rule, std::vector<std::string>& out, Faults& faults) {
  if (!value.is_list()) return refuse_type(value, "a list of texts", faults);
  const std::size_t faults_before = faults.size();
  out.clear();
  for (const Value& item : value.items) {
    std::string text;
    if (!read_text(item, rule, text, faults)) continue;
    if (std::find(out.begin(), out.end(), text) != out.end())
      faults.add(item.place, fmt::format("'{}' names \"{}\" twice", value.path, text));
    out.push_back(text);
  }
  return faults.size() == faults_before;
}

bool read_vector(const Value& value, Vec3& out, Faults& faults) {
  if (!value.is_list()) return refuse_type(value, "a list of 3 numbers", faults);
  if (value.items.size() != 3) {
    faults.add(value.place, fmt::format("'{}' has {} {}; it must be a list of 3 numbers", value.path, value.items.size(),
                                        value.items.size() == 1 ? "entry" : "entries"));
    return false;
  }
  const std::size_t faults_before = faults.size();
  for (int axis = 0; axis < 3; ++axis) read_number(value.items[static_cast<std::size_t>(axis)], Rule{}, out[axis], faults);
  return faults.size() == faults_before;
}

bool read_choice(const Value& value, const std::vector<std::string>& names, std::size_t& out, Faults& faults) {
  const std::string wanted = names.size() == 1 ? quoted_list(names) : "one of " + quoted_list(names);
  if (value.kind != Kind::text) return refuse_type(value, wanted, faults);
  const auto found = std::find(names.begin(), names.end(), value.text);
  if (found == names.end()) {
    const auto near = nearest(value.text, names);
    return refuse_value(value, wanted + (near ? "; did you mean \"" + *near + "\"?" : ""), faults);
  }
  out = static_cast<std::size_t>(found - names.begin());
  return true;
}

bool expect_table(const Value& value, Faults& faults) { return value.is_table() || refuse_type(value, "a table", faults); }

bool expect_list_of_tables(const Value& value, Faults& faults) {
  if (!value.is_list()) return refuse_type(value, "a list of tables", faults);
  const std::size_t faults_before = faults.size();
  for (const Value& item : value.items) expect_table(item, faults);
  return faults.size() == faults_before;
}

Value write_vector(const Vec3& vector) {
  return make_list({make_number(vector[0]), make_number(vector[1]), make_number(vector[2])});
}

Value write_texts(const std::vector<std::string>& texts) {
  Value list = make_list({});
  for (const std::string& text : texts) list.items.push_back(make_text(text));
  return list;
}

std::string allowed_numbers(const Rule& rule) {
  return rule.choices.empty() ? rule.range.symbols() : choices_in_words(rule.choices);
}

std::string allowed_names(const std::vector<std::string>& names) {
  std::vector<std::string> quoted;
  quoted.reserve(names.size());
  for (const std::string& name : names) quoted.push_back("`\"" + name + "\"`");
  return fmt::format("{}", fmt::join(quoted, ", "));
}

std::optional<Value> with_present_names(const Value& table, const std::vector<Rename>& renames, Faults& faults) {
  std::optional<Value> result;
  for (const auto& [old_name, name] : renames) {
    const Value* by_old_name = table.find(old_name);
    if (!by_old_name) continue;
    const std::string present_path = child_path(table.path, name);
    if (!result) result = table;
    const Value* by_name = table.find(name);
    const auto is_override = [](const Value& v) { return v.key_place.line == 0; };
    if (by_name && is_override(*by_name) == is_override(*by_old_name)) {
      faults.add(by_old_name->key_place,
                 fmt::format("'{}' and '{}' are both given; the first is the old name of the second: "
                             "give '{}' alone",
                             by_old_name->path, by_name->path, by_name->path));
    } else {
      faults.warn(by_old_name->key_place,
                  fmt::format("'{}' is now called '{}'; the old name is accepted in this version only", by_old_name->path,
                              present_path));
    }
    const bool old_counts = !by_name || is_override(*by_old_name);
    std::erase_if(result->items, [&](const Value& v) { return v.key == (old_counts ? name : old_name); });
    if (Value* entry = result->find(old_name)) entry->key = name;
  }
  return result;
}

void report_unknown_keys(const Value& table, const std::vector<std::string>& known, const std::vector<Rename>& renames,
                         Faults& faults) {
  std::vector<std::string> all_names = known;
  for (const Rename& rename : renames) all_names.push_back(rename.old_name);
  for (const Value& entry : table.items) {
    if (faults.is_full() || std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
    const auto near = nearest(entry.key, all_names);
    const auto renamed =
        std::find_if(renames.begin(), renames.end(), [&](const Rename& r) { return near && r.old_name == *near; });
    const std::string hint = renamed == renames.end()
                                 ? suggestion(entry.key, known)
                                 : fmt::format("; did you mean '{}', formerly '{}'?", renamed->name, *near);
    faults.add(entry.key_place, fmt::format("unknown {} '{}' {}{}", entry.is_table() ? "table" : "key", entry.key,
                                            in_table(table.path), hint));
  }
}

void report_missing_key(const Value& table, const std::string& key, bool is_table, Faults& faults) {
  if (is_table && table.path.empty())
    faults.add(table.place, fmt::format("required table [{}] is missing", key));
  else
    faults.add(table.place, fmt::format("required key '{}' is missing {}", key, in_table(table.path)));
}

void report_unused_key(const Value& key, const std::string& condition, Faults& faults) {
  faults.add(key.key_place, fmt::format("'{}' is given but applies only with {}", key.path, condition));
}

bool add_section(const TableText& section, std::vector<TableText>& sections) {
  for (const TableText& other : sections)
    if (other.title == section.title) return false;
  sections.push_back(section);
  return true;
}

}  // namespace bulkley::config
