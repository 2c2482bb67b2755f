#pragma once
// The contents of a scene file before interpretation: a tree of values with their places.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace bulkley::config {

/// Where something was written: a position in a file, or an override of the command line (line 0).
struct Place {
  std::string source;
  int line = 0;
  int column = 0;
  std::string text() const;  ///< "file:line:column", or the source alone
};

enum class Kind { none, boolean, integer, number, text, list, table, date };

/// A value with its key; `items` are the elements of a list or the entries of a table, in the order of the file.
struct Value {
  Kind kind = Kind::none;
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0.0;  ///< set for integers too
  std::string text;
  std::vector<Value> items;

  std::string key;      ///< empty in a list
  std::string path;     ///< from the root, as the command line writes it: "bodies.0.velocity"
  Place place;          ///< of the value
  Place key_place;      ///< of the key
  std::string comment;  ///< printed after the value; not read

  bool is_table() const { return kind == Kind::table; }
  bool is_list() const { return kind == Kind::list; }
  /// Entry of a table; null if there is none.
  const Value* find(std::string_view name) const;
  Value* find(std::string_view name);
};

Value make_boolean(bool value);
Value make_integer(std::int64_t value);
Value make_number(double value);
Value make_text(std::string value);
Value make_list(std::vector<Value> items);
Value make_table();
/// Appends an entry to a table; a value of no kind is left out.
void add_entry(Value& table, const std::string& key, Value value, const std::string& comment = "");

/// `value` in words for messages: `the text "abc"`, `the integer 3`, `a table`.
std::string in_words(const Value& value);
/// A table in messages: "[materials.fluid]".
std::string table_name(const std::string& path);
/// The place of a key, in messages: "in [materials.fluid]", or "at the top level".
std::string in_table(const std::string& path);
/// Path of the entry `key` of the table or list at `path`, its middle left out where it is very long.
std::string child_path(const std::string& path, const std::string& key);

/// `text` on one line, without control characters, and its middle left out where it is very long: for messages.
std::string printable(const std::string& text);
bool is_utf8(std::string_view text);

/// Collects the faults of an input, so that all are reported at once, and warnings about input that is accepted.
class Faults {
 public:
  void add(const Place& place, const std::string& sentence);
  /// A warning is no fault: it is not counted and never thrown.
  void warn(const Place& place, const std::string& sentence);
  std::size_t size() const { return n_; }
  /// Whether further faults are counted but not kept.
  bool is_full() const { return faults_.size() >= most; }
  /// Throws UsageError with one line per fault, ordered by their place; does nothing without faults.
  void throw_if_any() const;
  /// "file:line:column: sentence" of each warning, ordered by place.
  std::vector<std::string> warnings() const;

 private:
  struct Fault {
    Place place;
    std::string sentence;
  };
  static std::vector<std::string> sentences(std::vector<Fault> faults);
  static constexpr std::size_t most = 100;
  std::size_t n_ = 0;  ///< with those that are not kept
  std::vector<Fault> faults_;
  std::vector<Fault> warnings_;
};

}  // namespace bulkley::config
