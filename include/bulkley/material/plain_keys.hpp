#pragma once
// The keys of a constitutive law in [materials.NAME] of a scene.

#include <optional>
#include <string>

#include "bulkley/config/keys.hpp"

namespace bulkley {

/// The keys of a law:
///   using Input = ...;                                   what a scene may write, as optional members
///   static Input start(const Law&);                      the input as it is before any key was read
///   static const config::Keys<Input>& table();
///   static void fill(const config::Value& table, const Input&, Law&, config::Faults&);
///       Puts the input into a law that holds a preset's parameters, or NaN; faults on what is missing or contradictory.
///   static Input input(const Law&);                      the input that gives the law again
///   static config::Value write(const Law&);              the table that gives the law again
template <class Law>
struct LawKeys;

/// Faults for the numbers of a written table that nobody gave. Not collective.
void report_numbers_not_given(const config::Value& table, const config::Value& written, config::Faults& faults);

/// What LawKeys<Law> may derive from if the law's keys are its parameters; `table` is left to write. A parameter that starts as
/// NaN must be given.
template <class Law>
struct PlainKeys {
  using Input = typename Law::Parameters;
  static Input start(const Law& law) { return law.parameters; }
  static void fill(const config::Value& table, const Input& input, Law& law, config::Faults& faults) {
    law = Law{input};
    report_numbers_not_given(table, LawKeys<Law>::table().write(input), faults);
  }
  static Input input(const Law& law) { return law.parameters; }
  static config::Value write(const Law& law) { return LawKeys<Law>::table().write(law.parameters); }
};

/// What is wrong with a law's parameters, as one sentence: what is missing or out of its key's range, else what
/// parameter_fault(law.parameters) says, if the law has that function. Empty when nothing is. Not collective.
template <class Law>
std::optional<std::string> law_fault(const Law& law) {
  if (auto fault = LawKeys<Law>::table().fault(LawKeys<Law>::input(law))) return fault;
  if constexpr (requires { parameter_fault(law.parameters); }) return parameter_fault(law.parameters);
  return std::nullopt;
}

/// Reads the keys of a table, all but `law` and `preset`, into a law. False after a fault. Not collective.
template <class Law>
bool read_law(const config::Value& table, Law& law, config::Faults& faults) {
  const std::size_t faults_before = faults.size();
  typename LawKeys<Law>::Input input = LawKeys<Law>::start(law);
  if (!LawKeys<Law>::table().read(table, input, faults, {"law", "preset", "magnetic"})) return false;
  LawKeys<Law>::fill(table, input, law, faults);
  if (faults.size() != faults_before) return false;
  if (const auto fault = law_fault(law)) faults.add(table.place, config::table_name(table.path) + ": " + *fault);
  return faults.size() == faults_before;
}

}  // namespace bulkley
