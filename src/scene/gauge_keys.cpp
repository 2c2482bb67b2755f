#include "scene/gauge_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "config/groups.hpp"
#include "config/nearest.hpp"
#include "scene/output_keys.hpp"

namespace bulkley {

using config::Faults;
using config::Value;

config::Names<FaceName> names(config::Of<FaceName>) {
  config::Names<FaceName> result;
  for (std::size_t f = 0; f < face_names.size(); ++f) result.emplace_back(face_names[f], static_cast<FaceName>(f));
  return result;
}

namespace {

const std::string name_about = "Name of the columns; no other front, gauge or collider has it.";

void require_length(const Value& table, const char* key, const std::optional<Vec3>& vector, Faults& faults) {
  if (vector && !(vector->norm() > 0.0))
    faults.add(table.find(key)->place, fmt::format("'{}.{}' has no length; it must not be [0, 0, 0]", table.path, key));
}

/// Exactly one of two keys.
void require_one_of(const Value& table, const char* one, const char* other, Faults& faults) {
  const Value *first = table.find(one), *second = table.find(other);
  if (!first == !second)
    faults.add(table.place, fmt::format("{} has {} '{}' {} '{}'; give one of them", config::table_name(table.path),
                                        first ? "both" : "neither", one, first ? "and" : "nor", other));
}

/// Both keys or none.
void require_pair(const Value& table, const char* one, const char* other, Faults& faults) {
  const Value *first = table.find(one), *second = table.find(other);
  if (!first != !second)
    faults.add((first ? first : second)->key_place,
               fmt::format("{} has '{}' without '{}'; give both or neither", config::table_name(table.path),
                           first ? one : other, first ? other : one));
}

void check_gauge(const Value& table, Gauge& gauge, Faults& faults) {
  gauge.place = table.place.text();
  require_one_of(table, "face", "collider", faults);
  config::refuse_mixture(table, {"lower", "upper"}, "a box", {"center", "radius"}, "a disc or ball", faults);
  require_pair(table, "lower", "upper", faults);
  require_pair(table, "center", "radius", faults);
  if (gauge.lower && gauge.upper && !(gauge.lower->array() <= gauge.upper->array()).all())
    faults.add(table.find("upper")->place,
               fmt::format("'{}.upper' must not be less than 'lower' along any axis", table.path));
}

void check_front(const Value& table, Front& front, Faults& faults) {
  require_one_of(table, "direction", "axis", faults);
  require_length(table, "direction", front.direction, faults);
  require_length(table, "axis", front.axis, faults);
  if (front.eye && !((*front.eye)[2] > front.plane))
    faults.add(table.find("eye")->place, fmt::format("'{}.eye' is at z = {:g} and must be above the floor, 'plane' = {:g}",
                                                     table.path, (*front.eye)[2], front.plane));
}

}  // namespace

const config::Keys<Front>& keys(config::Of<Front>) {
  static const auto table =
      config::Keys<Front>(
          "How far the material reaches, as the column `NAME.reach [m]` of history.csv: along `direction`, or from an "
          "`axis`. "
          "Positions are those of the particles' centres: material ends half a particle spacing beyond, which is the cell "
          "size divided by twice the cube root of `particles_per_cell`.")
          .key("name", &Front::name, {.about = name_about, .required = true})
          .key("direction", &Front::direction,
               {.about = "Direction in which the reach is measured; its length does not matter.", .default_text = "none"})
          .key("axis", &Front::axis,
               {.about = "Direction of an axis through `origin`, instead of `direction`: the reach is the distance from the "
                         "axis. Its length does not matter.",
                .default_text = "none"})
          .key("origin", &Front::origin, {.about = "Where the reach is 0.", .unit = "m"})
          .key("material", &Front::material, {.about = "Counts particles of this material only.", .default_text = "all"})
          .key("quantile", &Front::quantile,
               {.about = "Part of the mass that reaches no farther; 1: the farthest particle.",
                .range = config::above_to(0.0, 1.0)})
          .key("eye", &Front::eye,
               {.about = "Measures the shadow that a lamp here throws on the floor: what a camera here sees as the edge. "
                         "Particles that are not below it do not count.",
                .unit = "m",
                .default_text = "none"})
          .key("plane", &Front::plane, {.about = "Height z of the floor under the shadow.", .unit = "m"})
          .only_with("an eye", [](const Front& front) { return front.eye.has_value(); })
          .check(check_front);
  return table;
}

const config::Keys<Gauge>& keys(config::Of<Gauge>) {
  static const auto table =
      config::Keys<Gauge>(
          "The force of the material on a patch of a wall, as the columns `NAME.force_x [N]`, `_y`, `_z` and "
          "`NAME.pressure [Pa]` of history.csv: means since the previous row; the pressure is the force into the wall over "
          "the patch's area. The patch is what lies of the wall within a box or a ball, or all of it.")
          .key("name", &Gauge::name, {.about = name_about, .required = true})
          .key("face", &Gauge::face, {.about = "Face of the domain on which to measure.", .default_text = "none"})
          .key("collider", &Gauge::collider,
               {.about = "Name of the collider on which to measure, instead of `face`. If it moves, the patch moves along.",
                .default_text = "none"})
          .key("lower", &Gauge::lower, {.about = "Lower corner of a box.", .unit = "m", .default_text = "none"})
          .key("upper", &Gauge::upper, {.about = "Upper corner of the box.", .unit = "m", .default_text = "none"})
          .key("center", &Gauge::center,
               {.about = "Centre of a ball, instead of a box; on a face, of a disc.", .unit = "m", .default_text = "none"})
          .key("radius", &Gauge::radius,
               {.about = "Radius of the ball.", .unit = "m", .range = config::above(0.0), .default_text = "none"})
          .check(check_gauge);
  return table;
}

namespace {

/// Columns of one name would be there twice.
void require_own_columns(const Value& output, const Scene& scene, Faults& faults) {
  std::map<std::string, std::string> owners;
  for (const Collider& collider : scene.colliders) owners.emplace(column_prefix(collider.name), "a collider");
  for (const RigidBody& body : scene.rigid_bodies) owners.emplace(column_prefix(body.name), "a rigid body");
  for (const Inflow& inflow : scene.inflows) owners.emplace(column_prefix(inflow.name), "an inflow");
  for (const char* list : {"front", "gauge"}) {
    const Value* entries = output.find(list);
    if (!entries) continue;
    for (const Value& entry : entries->items) {
      const Value* name = entry.find("name");
      const auto [found, is_new] =
          owners.emplace(column_prefix(name->text), fmt::format("another entry of [output.{}]", list));
      if (!is_new)
        faults.add(name->place, fmt::format("'{}' is \"{}\", which {} has already: their columns in history.csv would have "
                                            "the same names",
                                            name->path, name->text, found->second));
    }
  }
}

}  // namespace

std::string column_prefix(const std::string& name) {
  std::string prefix = name;
  std::replace_if(
      prefix.begin(), prefix.end(), [](char c) { return c == ',' || c == '"' || c == '\n' || c == '\r'; }, '_');
  return prefix;
}

void join_measurements(const Value& root, Scene& scene, Faults& faults) {
  const Value* output = root.find("output");
  if (!output) return;
  require_own_columns(*output, scene, faults);
  std::vector<std::string> materials, colliders;
  for (const NamedMaterial& material : scene.materials) materials.push_back(material.name);
  for (const Collider& collider : scene.colliders) colliders.push_back(collider.name);
  for (std::size_t f = 0; f < scene.output.fronts.size(); ++f) {
    Front& front = scene.output.fronts[f];
    if (!front.material) continue;
    const auto found = std::find(materials.begin(), materials.end(), *front.material);
    front.material_number = static_cast<int>(found - materials.begin());
    if (found != materials.end()) continue;
    const Value& value = *output->find("front")->items[f].find("material");
    faults.add(value.place, fmt::format("'{}' is \"{}\", which is not in [materials]{}", value.path, *front.material,
                                        config::suggestion(*front.material, materials)));
  }
  for (std::size_t g = 0; g < scene.output.gauges.size(); ++g) {
    Gauge& gauge = scene.output.gauges[g];
    const Value& entry = output->find("gauge")->items[g];
    if (gauge.collider) {
      const auto found = std::find(colliders.begin(), colliders.end(), *gauge.collider);
      gauge.collider_number = static_cast<int>(found - colliders.begin());
      if (found == colliders.end())
        faults.add(entry.find("collider")->place,
                   fmt::format("'{}.collider' is \"{}\", which is not in [[colliders]]{}", entry.path, *gauge.collider,
                               config::suggestion(*gauge.collider, colliders)));
    } else {
      const auto f = static_cast<std::size_t>(*gauge.face);
      const FaceBehaviour& kind = behaviour(scene.faces[f].kind);
      if (!kind.contact)
        faults.add(entry.find("face")->place,
                   fmt::format("'{}.face' is \"{}\", which is {}: there is no wall on which to measure", entry.path,
                               face_names[f], kind.name));
    }
  }
}

void check_gauges(const Scene& scene) {
  std::string faults;
  for (const Gauge& gauge : scene.output.gauges) {
    if (gauge_area(scene.grid, gauge, scene.colliders) > 0.0) continue;
    const std::string place = gauge.place.empty() ? "" : gauge.place + ": ";
    const std::string wall = gauge.face ? fmt::format("face '{}'", face_names[static_cast<std::size_t>(*gauge.face)])
                                        : fmt::format("the surface of collider '{}'", *gauge.collider);
    faults += fmt::format("{}{}gauge '{}' covers nothing of {}: {} must contain a part of it that lies in the domain",
                          faults.empty() ? "" : "\n", place, gauge.name, wall,
                          gauge.lower    ? "the box from 'lower' to 'upper'"
                          : gauge.center ? "the ball of 'radius' around 'center'"
                                         : "the wall");
  }
  if (!faults.empty()) throw UsageError(faults);
}

}  // namespace bulkley
