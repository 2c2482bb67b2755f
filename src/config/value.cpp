#include "bulkley/config/value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bulkley/base/error.hpp"
#include "bulkley/config/toml.hpp"

namespace bulkley::config {
namespace {

constexpr std::size_t longest_path = 200, longest_sentence = 2000;  ///< bytes

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xc0u) == 0x80u; }

/// Without the middle of what is longer than `longest`, cut between characters.
std::string shortened(const std::string& text, std::size_t longest) {
  if (text.size() <= longest) return text;
  std::size_t head = 2 * longest / 3, tail = text.size() - longest / 3;
  while (head > 0 && is_continuation(text[head])) --head;
  while (tail < text.size() && is_continuation(text[tail])) ++tail;
  return text.substr(0, head) + " ... " + text.substr(tail);
}

}  // namespace

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

std::string child_path(const std::string& path, const std::string& key) {
  return path.empty() ? shortened(key, longest_path) : shortened(path + "." + key, longest_path);
}

std::string printable(const std::string& text) {
  std::string result;
  for (const char c : shortened(text, longest_sentence))
    if (c == '\n')
      result += "\\n";
    else
      result += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return result;
}

bool is_utf8(std::string_view text) {
  const auto follows = [&](std::size_t at) { return at < text.size() && is_continuation(text[at]); };
  for (std::size_t at = 0; at < text.size();) {
    const auto byte = static_cast<unsigned char>(text[at]);
    const std::size_t n = byte < 0x80 ? 0 : byte >= 0xc2 && byte < 0xe0 ? 1 : byte >= 0xe0 && byte < 0xf0 ? 2 : 3;
    if (n == 3 && (byte < 0xf0 || byte > 0xf4)) return false;
    for (std::size_t k = 1; k <= n; ++k)
      if (!follows(at + k)) return false;
    const auto second = n > 1 ? static_cast<unsigned char>(text[at + 1]) : 0x90u;
    // Overlong forms, surrogates, and values beyond the last code point.
    if ((byte == 0xe0 && second < 0xa0) || (byte == 0xed && second > 0x9f) || (byte == 0xf0 && second < 0x90) ||
        (byte == 0xf4 && second > 0x8f))
      return false;
    at += n + 1;
  }
  return true;
}

void Faults::add(const Place& place, const std::string& sentence) {
  ++n_;
  if (!is_full()) faults_.push_back({place, printable(sentence)});
}

void Faults::warn(const Place& place, const std::string& sentence) {
  if (warnings_.size() < most) warnings_.push_back({place, printable(sentence)});
}

std::vector<std::string> Faults::sentences(std::vector<Fault> faults) {
  std::stable_sort(faults.begin(), faults.end(), [](const Fault& a, const Fault& b) {
    return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
  });
  std::vector<std::string> result;
  for (const Fault& fault : faults) result.push_back(fmt::format("{}: {}", fault.place.text(), fault.sentence));
  return result;
}

std::vector<std::string> Faults::warnings() const { return sentences(warnings_); }

void Faults::throw_if_any() const {
  if (faults_.empty()) return;
  std::string text = fmt::format("{}", fmt::join(sentences(faults_), "\n"));
  if (n_ > faults_.size()) text += fmt::format("\n... and {} more faults", n_ - faults_.size());
  throw UsageError(text);
}

}  // namespace bulkley::config
