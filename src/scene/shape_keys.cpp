#include "scene/shape_keys.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace bulkley {
namespace {

using config::Faults;
using config::Keys;
using config::Value;

constexpr double radians_per_degree = std::numbers::pi / 180.0;
constexpr auto length = config::above(0.0);
constexpr double not_given = std::numeric_limits<double>::quiet_NaN();
const Vec3 nowhere = Vec3::Constant(not_given);

void require_distinct_ends(const Value& table, const Vec3& start, const Vec3& end, Faults& faults) {
  if (!((end - start).norm() > 0.0))
    faults.add(table.place, "'" + table.path + "' has 'start' equal to 'end'; they must differ");
}

void require_parts(const Value& table, const Union& all, Faults& faults) {
  if (all.parts.empty())
    faults.add(table.find("parts")->place, "'" + table.path + ".parts' is empty; it must hold at least one shape");
}

/// An angle in degrees that gives back these radians bit for bit, as round a number as there is.
double degrees(double radians) {
  const double exact = radians / radians_per_degree;
  const double rounded = std::round(exact * 1e9) * 1e-9;
  const double up = std::nextafter(exact, INFINITY), down = std::nextafter(exact, -INFINITY);
  for (const double candidate : {std::round(exact), rounded, exact, up, down})
    if (candidate * radians_per_degree == radians) return candidate;
  return exact;
}

const config::Choice<decltype(Shape::kind)>& shape_types() {
  static const auto choice = config::Choice<decltype(Shape::kind)>("type")
                                 .add<Box>("box")
                                 .add<Sphere>("sphere")
                                 .add<Cylinder>("cylinder")
                                 .add<Capsule>("capsule")
                                 .add<Ellipsoid>("ellipsoid")
                                 .add<Plane>("plane")
                                 .add<Mesh>("mesh")
                                 .add<Union>("union")
                                 .add<Difference>("difference")
                                 .add<Complement>("complement");
  return choice;
}

}  // namespace

const Keys<Box>& keys(config::Of<Box>) {
  static const auto table =
      Keys<Box>("A box along the axes.", {nowhere, nowhere})
          .key("lower", &Box::lower, {.about = "Lower corner.", .unit = "m", .required = true})
          .key("upper", &Box::upper,
               {.about = "Upper corner, above the lower one along every axis.", .unit = "m", .required = true})
          .check([](const Value& value, Box& box, Faults& faults) {
            for (int axis = 0; axis < 3; ++axis)
              if (!(box.lower[axis] < box.upper[axis]))
                faults.add(value.find("upper")->place,
                           "'" + value.path + ".upper' must be greater than 'lower' along every axis; it is not along " +
                               std::string(1, "xyz"[axis]));
          });
  return table;
}

const Keys<Sphere>& keys(config::Of<Sphere>) {
  static const auto table =
      Keys<Sphere>("A ball.", {nowhere, not_given})
          .key("center", &Sphere::center, {.about = "Centre.", .unit = "m", .required = true})
          .key("radius", &Sphere::radius, {.about = "Radius.", .unit = "m", .range = length, .required = true});
  return table;
}

const Keys<Cylinder>& keys(config::Of<Cylinder>) {
  static const auto table =
      Keys<Cylinder>("A right circular cylinder with flat ends.", {nowhere, nowhere, not_given})
          .key("start", &Cylinder::start, {.about = "Centre of one end.", .unit = "m", .required = true})
          .key("end", &Cylinder::end, {.about = "Centre of the other end.", .unit = "m", .required = true})
          .key("radius", &Cylinder::radius, {.about = "Radius.", .unit = "m", .range = length, .required = true})
          .check(
              [](const Value& value, Cylinder& c, Faults& faults) { require_distinct_ends(value, c.start, c.end, faults); });
  return table;
}

const Keys<Capsule>& keys(config::Of<Capsule>) {
  static const auto table =
      Keys<Capsule>("A cylinder with round ends: all points within the radius of a segment.", {nowhere, nowhere, not_given})
          .key("start", &Capsule::start, {.about = "One end of the segment.", .unit = "m", .required = true})
          .key("end", &Capsule::end, {.about = "The other end of the segment.", .unit = "m", .required = true})
          .key("radius", &Capsule::radius, {.about = "Radius.", .unit = "m", .range = length, .required = true})
          .check(
              [](const Value& value, Capsule& c, Faults& faults) { require_distinct_ends(value, c.start, c.end, faults); });
  return table;
}

const Keys<Ellipsoid>& keys(config::Of<Ellipsoid>) {
  static const auto table =
      Keys<Ellipsoid>("An ellipsoid with its axes along x, y and z; `rotation` rotates it.", {nowhere, nowhere})
          .key("center", &Ellipsoid::center, {.about = "Centre.", .unit = "m", .required = true})
          .key("radii", &Ellipsoid::radii, {.about = "Half axes along x, y, z, each > 0.", .unit = "m", .required = true})
          .check([](const Value& value, Ellipsoid& ellipsoid, Faults& faults) {
            if (!(ellipsoid.radii.minCoeff() > 0.0))
              faults.add(value.find("radii")->place, "'" + value.path + ".radii' must be greater than 0 along every axis");
          });
  return table;
}

const Keys<Plane>& keys(config::Of<Plane>) {
  static const auto table =
      Keys<Plane>("A half-space; for colliders only.", {nowhere, nowhere})
          .key("point", &Plane::point, {.about = "A point of the surface.", .unit = "m", .required = true})
          .key("normal", &Plane::normal,
               {.about = "Points out of the solid; its length does not matter but may not be 0.", .required = true})
          .check([](const Value& value, Plane& plane, Faults& faults) {
            if (!(plane.normal.norm() > 0.0))
              faults.add(value.find("normal")->place, "'" + value.path + ".normal' has no length; it must not be [0, 0, 0]");
          });
  return table;
}

config::Rule length_rule(const std::string& about) {
  return {.about = about, .unit = "m", .range = config::above(0.0), .required = true};
}

config::Names<Axis> names(config::Of<Axis>) { return {{"x", Axis::x}, {"y", Axis::y}, {"z", Axis::z}}; }

const Keys<Mesh>& keys(config::Of<Mesh>) {
  static const auto table =
      Keys<Mesh>("What a triangle mesh encloses, with or without holes (docs/meshes.md).")
          .key("file", &Mesh::file,
               {.about = "An OBJ, STL or PLY file, by a path relative to the scene file's folder; or `builtin:hare` or "
                         "`builtin:dragon`, figures that need no file.",
                .required = true})
          .key("up", &Mesh::up,
               {.about =
                    "The axis of the file that points up, along z: `y` rotates the mesh by 90 degrees about x, `x` about y. "
                    "This is applied first."})
          .key("scale", &Mesh::scale, {.about = "Length of the file's unit.", .unit = "m", .range = length})
          .only_with("no size", [](const Mesh& mesh) { return !mesh.size; })
          .key("size", &Mesh::size,
               {.about = "Largest side of the mesh's bounds, instead of `scale`.",
                .unit = "m",
                .range = length,
                .default_text = "by `scale`"})
          .key("center", &Mesh::center,
               {.about = "Position of the centre of the mesh's bounds.", .unit = "m", .default_text = "as in the file"})
          .check([](const Value& value, Mesh& mesh, Faults& faults) {
            const Value& file = *value.find("file");
            mesh.place = file.place.text();
            if (mesh.file.empty()) faults.add(file.place, "'" + value.path + ".file' is empty; it must name a mesh");
          });
  return table;
}

const Keys<Union>& keys(config::Of<Union>) {
  static const auto table =
      Keys<Union>("Everything that is in one of its parts.")
          .key("parts", &Union::parts, {.about = "Shapes of any type.", .required = true})
          .check([](const Value& value, Union& all, Faults& faults) { require_parts(value, all, faults); });
  return table;
}

const Keys<Complement>& keys(config::Of<Complement>) {
  static const auto table =
      Keys<Complement>("Everything outside all of its parts, such as the wall of a pipe; for colliders only.")
          .key("parts", [](auto& c) -> auto& { return c.inside.parts; }, {.about = "Shapes of any type.", .required = true})
          .check([](const Value& value, Complement& c, Faults& faults) { require_parts(value, c.inside, faults); });
  return table;
}

const Keys<Difference>& keys(config::Of<Difference>) {
  static const auto table =
      Keys<Difference>("The first of its parts without the others: a tube is a cylinder without a thinner one.")
          .key("parts", &Difference::parts, {.about = "Shapes of any type, at least two.", .required = true})
          .check([](const Value& value, Difference& difference, Faults& faults) {
            if (difference.parts.size() < 2)
              faults.add(value.find("parts")->place, "'" + value.path + ".parts' must hold at least two shapes");
          });
  return table;
}

const Keys<RotationInput>& keys(config::Of<RotationInput>) {
  static const auto table =
      Keys<RotationInput>("A rotation about an axis.")
          .key("axis", &RotationInput::axis,
               {.about = "Direction of the axis; its length does not matter but may not be 0."})
          .key("angle", &RotationInput::angle,
               {.about = "Angle, by the right-hand rule.", .unit = "degrees", .required = true})
          .key("origin", &RotationInput::origin, {.about = "A point on the axis.", .unit = "m"})
          .check([](const Value& value, RotationInput& rotation, Faults& faults) {
            if (!(rotation.axis.norm() > 0.0))
              faults.add(value.find("axis")->place, "'" + value.path + ".axis' has no length; it must not be [0, 0, 0]");
          });
  return table;
}

const Keys<PlacementInput>& keys(config::Of<PlacementInput>) {
  static const auto table =
      Keys<PlacementInput>("Keys of shapes of any type: the shape is rotated first, then translated.")
          .key("rotation", &PlacementInput::rotation, {.about = "Rotation of the shape.", .default_text = "none"})
          .key("translation", &PlacementInput::translation,
               {.about = "Translation of the shape after its rotation.", .unit = "m", .default_text = "none"});
  return table;
}

namespace config {

std::string Codec<Shape>::allowed(const Rule&) { return "`type` = " + allowed_names(shape_types().names()); }

bool Codec<Shape>::read(const Value& value, const Rule&, Shape& out, Faults& faults) {
  const std::vector<std::string> placement_names = keys(Of<PlacementInput>{}).names();
  if (!shape_types().read(value, out.kind, faults, placement_names)) return false;
  Value placement_table = config::make_table();
  placement_table.path = value.path;
  placement_table.place = value.place;
  placement_table.key_place = value.key_place;
  for (const std::string& name : placement_names)
    if (const Value* entry = value.find(name)) placement_table.items.push_back(*entry);
  if (placement_table.items.empty()) return true;

  PlacementInput input;
  if (!keys(Of<PlacementInput>{}).read(placement_table, input, faults)) return false;
  Placed placed;
  placed.part = std::make_shared<const Shape>(std::exchange(out, Shape{}));
  if (input.rotation) {
    placed.axis = input.rotation->axis;
    placed.angle = input.rotation->angle * radians_per_degree;
    placed.origin = input.rotation->origin;
  }
  if (input.translation) placed.translation = *input.translation;
  out.kind = std::move(placed);
  return true;
}

Value Codec<Shape>::write(const Shape& shape) {
  const Placed* placed = std::get_if<Placed>(&shape.kind);
  if (!placed) return shape_types().write(shape.kind);
  const bool placed_twice = std::holds_alternative<Placed>(placed->part->kind);
  Value table = Codec<Shape>::write(placed_twice ? Shape{Union{{*placed->part}}} : *placed->part);
  PlacementInput input;
  input.rotation = RotationInput{placed->axis, degrees(placed->angle), placed->origin};
  input.translation = placed->translation;
  for (Value& entry : keys(Of<PlacementInput>{}).write(input).items) table.items.push_back(std::move(entry));
  return table;
}

void Codec<Shape>::describe(const std::string&, std::vector<TableText>& out) {
  shape_types().describe("Shapes", "shape", out);
  keys(Of<PlacementInput>{}).describe("Shapes, any type", "shape", out);
}

}  // namespace config
}  // namespace bulkley
