#pragma once
// How a C++ type is read from a value and written back: `Codec<T>`. Specialise it next to a type that is not covered here.
//
//   static std::string type(const Rule&);                                  as the reference page names it
//   static std::string allowed(const Rule&);                               as the reference page states the range
//   static bool read(const Value&, const Rule&, T&, Faults&);              false after a fault
//   static Value write(const T&);                                          Kind::none: leave the key out
//   static void describe(const std::string& path, std::vector<TableText>&);  sections of its own on the reference page

#include <concepts>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bulkley/base/types.hpp"
#include "bulkley/config/rule.hpp"
#include "bulkley/config/value.hpp"

namespace bulkley::config {

/// Names a type in the functions that are declared next to it: `keys(Of<S>)` for a table, `names(Of<E>)` for an enumeration.
template <class T>
struct Of {};

/// The names of an enumeration's values, as scenes write them.
template <class E>
using Names = std::vector<std::pair<std::string, E>>;

// The readers of the plain types; each reports one fault and returns false, or stores the value.
bool read_number(const Value& value, const Rule& rule, double& out, Faults& faults);
bool read_integer(const Value& value, const Rule& rule, std::int64_t lowest, std::int64_t highest, std::int64_t& out,
                  Faults& faults);
bool read_boolean(const Value& value, bool& out, Faults& faults);
bool read_text(const Value& value, const Rule& rule, std::string& out, Faults& faults);
bool read_texts(const Value& value, const Rule& rule, std::vector<std::string>& out, Faults& faults);
bool read_vector(const Value& value, Vec3& out, Faults& faults);
/// Index of the text among `names`.
bool read_choice(const Value& value, const std::vector<std::string>& names, std::size_t& out, Faults& faults);
bool expect_table(const Value& value, Faults& faults);
bool expect_list_of_tables(const Value& value, Faults& faults);
Value write_vector(const Vec3& vector);
Value write_texts(const std::vector<std::string>& texts);
std::string allowed_numbers(const Rule& rule);
/// `"a"`, `"b"` for the reference page.
std::string allowed_names(const std::vector<std::string>& names);

/// What most types share.
struct PlainCodec {
  static std::string allowed(const Rule&) { return ""; }
  static void describe(const std::string&, std::vector<TableText>&) {}
};

template <class T>
struct Codec;

template <>
struct Codec<double> : PlainCodec {
  static std::string type(const Rule& rule) { return rule.duration ? "number or duration" : "number"; }
  static std::string allowed(const Rule& rule) { return allowed_numbers(rule); }
  static bool read(const Value& v, const Rule& rule, double& out, Faults& faults) {
    return read_number(v, rule, out, faults);
  }
  static Value write(double x) { return make_number(x); }
};

template <>
struct Codec<bool> : PlainCodec {
  static std::string type(const Rule&) { return "boolean"; }
  static bool read(const Value& v, const Rule&, bool& out, Faults& faults) { return read_boolean(v, out, faults); }
  static Value write(bool x) { return make_boolean(x); }
};

template <std::integral T>
struct Codec<T> : PlainCodec {
  static std::string type(const Rule&) { return "integer"; }
  static std::string allowed(const Rule& rule) { return allowed_numbers(rule); }
  static bool read(const Value& v, const Rule& rule, T& out, Faults& faults) {
    constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
    constexpr auto highest = std::in_range<std::int64_t>(std::numeric_limits<T>::max())
                                 ? static_cast<std::int64_t>(std::numeric_limits<T>::max())
                                 : largest;
    std::int64_t integer = 0;
    if (!read_integer(v, rule, static_cast<std::int64_t>(std::numeric_limits<T>::min()), highest, integer, faults))
      return false;
    out = static_cast<T>(integer);
    return true;
  }
  static Value write(T x) { return make_integer(static_cast<std::int64_t>(x)); }
};

template <>
struct Codec<std::string> : PlainCodec {
  static std::string type(const Rule&) { return "text"; }
  static bool read(const Value& v, const Rule& rule, std::string& out, Faults& faults) {
    return read_text(v, rule, out, faults);
  }
  static Value write(const std::string& x) { return make_text(x); }
};

template <>
struct Codec<std::vector<std::string>> : PlainCodec {
  static std::string type(const Rule&) { return "list of text"; }
  static std::string allowed(const Rule& rule);
  static bool read(const Value& v, const Rule& rule, std::vector<std::string>& out, Faults& faults) {
    return read_texts(v, rule, out, faults);
  }
  static Value write(const std::vector<std::string>& x) { return write_texts(x); }
};

template <>
struct Codec<Vec3> : PlainCodec {
  static std::string type(const Rule&) { return "3 numbers"; }
  static bool read(const Value& v, const Rule&, Vec3& out, Faults& faults) { return read_vector(v, out, faults); }
  static Value write(const Vec3& x) { return write_vector(x); }
};

template <class E>
  requires std::is_enum_v<E>
struct Codec<E> : PlainCodec {
  static std::vector<std::string> words() {
    std::vector<std::string> result;
    for (const auto& [word, e] : names(Of<E>{})) result.push_back(word);
    return result;
  }
  static std::string type(const Rule&) { return "name"; }
  static std::string allowed(const Rule&) { return allowed_names(words()); }
  static bool read(const Value& v, const Rule&, E& out, Faults& faults) {
    std::size_t index = 0;
    if (!read_choice(v, words(), index, faults)) return false;
    out = names(Of<E>{})[index].second;
    return true;
  }
  static Value write(E x) {
    for (const auto& [word, e] : names(Of<E>{}))
      if (e == x) return make_text(word);
    return {};
  }
};

inline std::string Codec<std::vector<std::string>>::allowed(const Rule& rule) { return allowed_names(rule.names); }

/// A key that may be left out without a default.
template <class T>
struct Codec<std::optional<T>> : PlainCodec {
  static std::string type(const Rule& rule) { return Codec<T>::type(rule); }
  static std::string allowed(const Rule& rule) { return Codec<T>::allowed(rule); }
  static bool read(const Value& v, const Rule& rule, std::optional<T>& out, Faults& faults) {
    T inner{};
    if (!Codec<T>::read(v, rule, inner, faults)) return false;
    out = inner;
    return true;
  }
  static Value write(const std::optional<T>& x) { return x ? Codec<T>::write(*x) : Value{}; }
  static void describe(const std::string& path, std::vector<TableText>& out) { Codec<T>::describe(path, out); }
};

}  // namespace bulkley::config
