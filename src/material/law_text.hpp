#pragma once
// What the family Material asks of the source file of each of its laws.

#include <optional>
#include <string>
#include <vector>

#include "bulkley/config/value.hpp"
#include "bulkley/material/added_law.hpp"

namespace bulkley {

/// A law as scenes and messages see it. The members are defined in laws/shared_keys.hpp; laws/<law>.cpp declares the law's keys
/// and ends with `template struct LawText<Law>;`, so that only that file needs them. Not collective.
template <class Law>
struct LawText {
  /// Reads the keys of a table, all but `law`, `preset` and `magnetic`, into the law. False after a fault.
  static bool read(const config::Value& table, Law& law, config::Faults& faults);
  /// The table that gives the law again, without its name.
  static config::Value write(const Law& law);
  /// Its section of the input reference.
  static void describe(const std::string& title, const std::string& path, std::vector<config::TableText>& out);
  /// What is wrong with the parameters, as one sentence; empty when nothing is.
  static std::optional<std::string> fault(const Law& law);
};

template <>
struct LawText<AddedLaw> {
  static bool read(const config::Value& table, AddedLaw& law, config::Faults& faults) {
    auto model = law.parameters.model->read(table, faults);
    if (!model) return false;
    law.parameters.model = std::move(model);
    return true;
  }
  static config::Value write(const AddedLaw& law) { return law.parameters.model->write(); }
  static std::optional<std::string> fault(const AddedLaw& law) { return law.parameters.model->fault(); }
};

}  // namespace bulkley
