#pragma once
// Shapes in a scene: { type = "sphere", center = [0, 0, 1], radius = 0.1, rotation = {...}, translation = [...] }.

#include "config/choice.hpp"
#include "geometry/shape.hpp"

namespace bulkley {

const config::Keys<Box>& keys(config::Of<Box>);
const config::Keys<Sphere>& keys(config::Of<Sphere>);
const config::Keys<Cylinder>& keys(config::Of<Cylinder>);
const config::Keys<Capsule>& keys(config::Of<Capsule>);
const config::Keys<Ellipsoid>& keys(config::Of<Ellipsoid>);
const config::Keys<Plane>& keys(config::Of<Plane>);
const config::Keys<Mesh>& keys(config::Of<Mesh>);
const config::Keys<Union>& keys(config::Of<Union>);
const config::Keys<Complement>& keys(config::Of<Complement>);
const config::Keys<Difference>& keys(config::Of<Difference>);

config::Names<Axis> names(config::Of<Axis>);

/// Of a key that must be given: a length above zero, m.
config::Rule length_rule(const std::string& about);

/// The turn of a placed shape as scenes write it.
struct RotationInput {
  Vec3 axis = Vec3::UnitZ();
  double angle = 0.0;  ///< degrees
  Vec3 origin = Vec3::Zero();
};
const config::Keys<RotationInput>& keys(config::Of<RotationInput>);

/// The keys that any shape may carry.
struct PlacementInput {
  std::optional<RotationInput> rotation;
  std::optional<Vec3> translation;
};
const config::Keys<PlacementInput>& keys(config::Of<PlacementInput>);

namespace config {

template <>
struct Codec<Shape> : PlainCodec {
  static std::string type(const Rule&) { return "shape"; }
  static std::string allowed(const Rule&);
  static bool read(const Value& value, const Rule& rule, Shape& out, Faults& faults);
  static Value write(const Shape& shape);
  static void describe(const std::string& path, std::vector<TableText>& out);
};

}  // namespace config
}  // namespace bulkley
