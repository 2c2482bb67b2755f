#pragma once
// [materials.NAME] of a scene: `law` and its keys, or `preset` and the keys that differ from it.

#include "bulkley/config/codec.hpp"
#include "material/material.hpp"

namespace bulkley::config {

template <>
struct Codec<std::vector<NamedMaterial>> : PlainCodec {
  static std::string type(const Rule&) { return "table"; }
  static bool read(const Value& value, const Rule& rule, std::vector<NamedMaterial>& out, Faults& faults);
  static Value write(const std::vector<NamedMaterial>& materials);
  static void describe(const std::string& path, std::vector<TableText>& out);
};

}  // namespace bulkley::config
