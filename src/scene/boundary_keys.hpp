#pragma once
// Keys of [boundaries] and [[colliders]] of a scene.

#include "bulkley/config/keys.hpp"
#include "grid/boundary.hpp"

namespace bulkley {

config::Names<Contact> names(config::Of<Contact>);
config::Names<FaceKind> names(config::Of<FaceKind>);
const config::Keys<Face>& keys(config::Of<Face>);
const config::Keys<Faces>& keys(config::Of<Faces>);
const config::Keys<Collider>& keys(config::Of<Collider>);
const config::Keys<KeyFrame>& keys(config::Of<KeyFrame>);

namespace config {

/// A face is its kind, or a table with the kind and what belongs to it.
template <>
struct Codec<Face> : PlainCodec {
  static std::string type(const Rule&) { return "name or table"; }
  static std::string allowed(const Rule& rule) { return Codec<FaceKind>::allowed(rule); }
  static bool read(const Value& value, const Rule& rule, Face& out, Faults& faults);
  static Value write(const Face& face);
  static void describe(const std::string& path, std::vector<TableText>& out);
};

}  // namespace config
}  // namespace bulkley
