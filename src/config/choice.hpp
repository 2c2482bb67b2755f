#pragma once
// A table with a key that selects the struct that the rest fills: shapes by `type`.

#include <functional>
#include <variant>

#include "bulkley/config/keys.hpp"

namespace bulkley::config {

/// V: a std::variant of structs whose keys are declared.
template <class V>
class Choice {
 public:
  /// `tag`: the key that names the alternative.
  explicit Choice(std::string tag) : tag_(std::move(tag)) {}

  /// Declares `name` as the name of the alternative S of V.
  template <class S>
  Choice& add(const std::string& name) {
    Alternative a;
    a.name = name;
    a.read = [](const Value& table, V& out, Faults& faults, const std::vector<std::string>& others) {
      return keys(Of<S>{}).read(table, out.template emplace<S>(keys(Of<S>{}).defaults()), faults, others);
    };
    a.write = [](const V& v) {
      const S* s = std::get_if<S>(&v);
      return s ? keys(Of<S>{}).write(*s) : Value{};
    };
    a.describe = [](const std::string& title, const std::string& path, std::vector<TableText>& out) {
      keys(Of<S>{}).describe(title, path, out);
    };
    alternatives_.push_back(std::move(a));
    return *this;
  }

  /// `others`: keys that other code reads.
  bool read(const Value& table, V& out, Faults& faults, std::vector<std::string> others = {}) const {
    if (!expect_table(table, faults)) return false;
    const Value* tag = table.find(tag_);
    if (!tag) {
      report_missing_key(table, tag_, false, faults);
      return false;
    }
    std::size_t index = 0;
    if (!read_choice(*tag, names(), index, faults)) return false;
    others.push_back(tag_);
    return alternatives_[index].read(table, out, faults, others);
  }

  Value write(const V& v) const {
    for (const Alternative& a : alternatives_) {
      Value body = a.write(v);
      if (body.kind == Kind::none) continue;
      Value table = make_table();
      add_entry(table, tag_, make_text(a.name));
      for (Value& entry : body.items) table.items.push_back(std::move(entry));
      return table;
    }
    return {};
  }

  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const Alternative& a : alternatives_) result.push_back(a.name);
    return result;
  }

  /// One section per alternative, titled `<title>, type = "<name>"`.
  void describe(const std::string& title, const std::string& path, std::vector<TableText>& out) const {
    for (const Alternative& a : alternatives_) a.describe(title + ", " + tag_ + " = \"" + a.name + "\"", path, out);
  }

 private:
  struct Alternative {
    std::string name;
    std::function<bool(const Value&, V&, Faults&, const std::vector<std::string>&)> read;
    std::function<Value(const V&)> write;
    std::function<void(const std::string&, const std::string&, std::vector<TableText>&)> describe;
  };
  std::string tag_;
  std::vector<Alternative> alternatives_;
};

}  // namespace bulkley::config
