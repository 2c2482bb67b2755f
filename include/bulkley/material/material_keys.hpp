#pragma once
// [materials.NAME] of a scene: `law` and its keys, or `preset` and the keys that differ from it.
//
// A law joins by a specialisation of LawKeys beside its header; its name is the law's own.

#include "bulkley/config/keys.hpp"
#include "bulkley/material/material.hpp"

namespace bulkley {

/// The keys of a law:
///   using Input = ...;                                   what a scene may write, as optional members
///   static Input start(const Law&);                      the input as it is before any key was read
///   static const config::Keys<Input>& table();
///   static void fill(const config::Value& table, const Input&, Law&, config::Faults&);
///       Puts the input into a law that holds a preset's parameters, or NaN; faults on what is missing or contradictory.
///   static config::Value write(const Law&);              the table that gives the law again
template <class Law>
struct LawKeys;

namespace config {

template <>
struct Codec<std::vector<NamedMaterial>> : PlainCodec {
  static std::string type(const Rule&) { return "table"; }
  static bool read(const Value& value, const Rule& rule, std::vector<NamedMaterial>& out, Faults& faults);
  static Value write(const std::vector<NamedMaterial>& materials);
  static void describe(const std::string& path, std::vector<TableText>& out);
};

}  // namespace config
}  // namespace bulkley
