#pragma once
// The keys of a table, declared once next to the struct they fill:
//
//   inline const config::Keys<Wind>& keys(config::Of<Wind>) {
//     static const auto table = config::Keys<Wind>("The air around the scene.")
//         .key("speed", &Wind::speed, {.about = "How fast it blows.", .unit = "m/s", .range = config::at_least(0.0)});
//     return table;
//   }
//
// Reading, messages, the dump of the effective input and the reference page all come from the declarations. Defaults are the
// struct's own.

#include <functional>
#include <optional>

#include "bulkley/config/codec.hpp"
#include "bulkley/config/toml.hpp"

namespace bulkley::config {

/// A key's name in the version before, and its present name.
struct Rename {
  std::string old_name, name;
};

/// The table with present names where it uses old ones, each with a warning; nothing if it uses none. Both names of one key
/// are a fault, unless only one of them is an override of the command line, which then counts. Paths and places stay as
/// written.
std::optional<Value> with_present_names(const Value& table, const std::vector<Rename>& renames, Faults& faults);
/// `known`: the present names; hints also recognise misspelt old names.
void report_unknown_keys(const Value& table, const std::vector<std::string>& known, const std::vector<Rename>& renames,
                         Faults& faults);
void report_missing_key(const Value& table, const std::string& key, bool is_table, Faults& faults);
void report_unused_key(const Value& key, const std::string& condition, Faults& faults);
/// Appends the section unless one of that title is there.
bool add_section(const TableText& section, std::vector<TableText>& sections);

template <class S>
class Keys {
 public:
  /// `about`: one sentence on the table. `defaults`: what a table without any key gives.
  explicit Keys(std::string about, S defaults = S{}) : about_(std::move(about)), defaults_(std::move(defaults)) {}

  /// Declares a key. `member`: a pointer to member, or `[](auto& s) -> auto& { return s.inner.member; }`.
  template <class Member>
  Keys& key(const std::string& name, Member member, Rule rule) {
    using T = std::remove_cvref_t<std::invoke_result_t<Member, S&>>;
    Key k;
    k.range = rule.range;
    k.may_be_infinite = rule.may_be_infinite;
    k.text = {name, Codec<T>::type(rule), rule.unit, rule.default_text, Codec<T>::allowed(rule), rule.about, rule.required};
    if (!rule.required && k.text.default_text.empty()) {
      const Value value = Codec<T>::write(std::invoke(member, defaults_));
      if (value.kind != Kind::none && !value.is_table()) k.text.default_text = "`" + print_inline(value) + "`";
    }
    k.read = [member, rule](const Value& v, S& s, Faults& faults) {
      return Codec<T>::read(v, rule, std::invoke(member, s), faults);
    };
    k.write = [member](const S& s) { return Codec<T>::write(std::invoke(member, s)); };
    k.describe = [name](const std::string& path, std::vector<TableText>& out) {
      Codec<T>::describe(child_path(path, name), out);
    };
    keys_.push_back(std::move(k));
    return *this;
  }

  /// The key declared last counts only where `applies`; elsewhere giving it is a fault. `condition`: `scheme = "blend"`.
  Keys& only_with(const std::string& condition, std::function<bool(const S&)> applies) {
    keys_.back().condition = condition;
    keys_.back().applies = std::move(applies);
    keys_.back().text.about += " Only with `" + condition + "`.";
    return *this;
  }

  /// The key declared last was called `old_name` in the version before: scenes may use that name for one version more, with
  /// a warning. Checks of this table find the key by its present name; those of an enclosing table only if the scene uses
  /// it.
  Keys& formerly(const std::string& old_name) {
    keys_.back().text.old_name = old_name;
    return *this;
  }

  /// A check over several keys, made after all of them were read without a fault; it may also fill derived members.
  Keys& check(std::function<void(const Value& table, S&, Faults&)> function) {
    check_ = std::move(function);
    return *this;
  }

  /// Fills `s`, which should hold the defaults. `others`: keys of the table that other code reads.
  bool read(const Value& given_table, S& s, Faults& faults, const std::vector<std::string>& others = {}) const {
    if (!expect_table(given_table, faults)) return false;
    const std::size_t faults_before = faults.size();
    const std::optional<Value> renamed = with_present_names(given_table, renames(), faults);
    const Value& table = renamed ? *renamed : given_table;
    std::vector<std::string> known = names();
    known.insert(known.end(), others.begin(), others.end());
    report_unknown_keys(table, known, renames(), faults);
    bool sound = true;
    for (const Key& k : keys_)
      if (const Value* v = table.find(k.text.name)) sound = k.read(*v, s, faults) && sound;
    for (const Key& k : keys_) {
      const bool applies = !k.applies || k.applies(s);
      const Value* given = table.find(k.text.name);
      if (given && !applies && sound) report_unused_key(*given, k.condition, faults);
      if (!given && k.text.required && applies) report_missing_key(table, k.text.name, k.text.type == "table", faults);
    }
    if (check_ && faults.size() == faults_before) check_(table, s, faults);
    return faults.size() == faults_before;
  }

  /// The table that gives `s` again; units are comments of the values.
  Value write(const S& s) const {
    Value table = make_table();
    for (const Key& k : keys_)
      if (!k.applies || k.applies(s)) add_entry(table, k.text.name, k.write(s), k.text.unit);
    return table;
  }

  /// What is wrong with the first number of `s` that is missing (NaN) or out of its key's range, as one sentence; empty when
  /// nothing is. For structs that a program filled: what was read has been checked.
  std::optional<std::string> fault(const S& s) const {
    for (const Key& k : keys_) {
      if (k.applies && !k.applies(s)) continue;
      const Value value = k.write(s);
      if (value.kind != Kind::number) continue;
      if (auto fault = number_fault(k.text.name, value.number, k.range, k.may_be_infinite)) return fault;
    }
    return std::nullopt;
  }

  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const Key& k : keys_) result.push_back(k.text.name);
    return result;
  }

  std::vector<Rename> renames() const {
    std::vector<Rename> result;
    for (const Key& k : keys_)
      if (!k.text.old_name.empty()) result.push_back({k.text.old_name, k.text.name});
    return result;
  }

  /// Adds the table's section and those of the tables in it to the reference page, once.
  void describe(const std::string& title, const std::string& path, std::vector<TableText>& out) const {
    TableText section{title, about_, {}};
    for (const Key& k : keys_) section.keys.push_back(k.text);
    if (!add_section(section, out)) return;
    for (const Key& k : keys_) k.describe(path, out);
  }

  const S& defaults() const { return defaults_; }

 private:
  struct Key {
    KeyText text;
    Range range;
    bool may_be_infinite = false;
    std::string condition;
    std::function<bool(const Value&, S&, Faults&)> read;
    std::function<Value(const S&)> write;
    std::function<bool(const S&)> applies;
    std::function<void(const std::string&, std::vector<TableText>&)> describe;
  };
  std::string about_;
  S defaults_;
  std::vector<Key> keys_;
  std::function<void(const Value&, S&, Faults&)> check_;
};

/// A struct whose keys are declared.
template <class T>
concept HasKeys = requires { keys(Of<T>{}); };

template <HasKeys T>
struct Codec<T> : PlainCodec {
  static std::string type(const Rule&) { return "table"; }
  static bool read(const Value& v, const Rule&, T& out, Faults& faults) { return keys(Of<T>{}).read(v, out, faults); }
  static Value write(const T& x) { return keys(Of<T>{}).write(x); }
  static void describe(const std::string& path, std::vector<TableText>& out) {
    keys(Of<T>{}).describe("[" + path + "]", path, out);
  }
};

/// A list of tables.
template <class T>
struct Codec<std::vector<T>> : PlainCodec {
  static std::string type(const Rule&) { return "list of tables"; }
  static bool read(const Value& v, const Rule& rule, std::vector<T>& out, Faults& faults) {
    if (!expect_list_of_tables(v, faults)) return false;
    out.clear();
    bool sound = true;
    for (const Value& item : v.items) {
      T entry{};
      sound = Codec<T>::read(item, rule, entry, faults) && sound;
      out.push_back(std::move(entry));
    }
    return sound;
  }
  static Value write(const std::vector<T>& x) {
    Value list = make_list({});
    for (const T& entry : x) list.items.push_back(Codec<T>::write(entry));
    return list;
  }
  static void describe(const std::string& path, std::vector<TableText>& out) {
    std::string inner = path;
    std::erase_if(inner, [](char c) { return c == '[' || c == ']'; });  // of a list around this one
    Codec<T>::describe("[" + inner + "]", out);
  }
};

}  // namespace bulkley::config
