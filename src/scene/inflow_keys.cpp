#include "scene/inflow_keys.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"
#include "config/choice.hpp"
#include "config/nearest.hpp"
#include "particle/feed_frames.hpp"
#include "scene/scene.hpp"
#include "scene/shape_keys.hpp"

namespace bulkley {
namespace {

using config::Faults;
using config::Keys;
using config::Value;

const config::Choice<Section>& section_types() {
  static const auto choice =
      config::Choice<Section>("type").add<DiscSection>("disc").add<RectangleSection>("rectangle").add<ShapeSection>("shape");
  return choice;
}

void check_inflow(const Value& table, Inflow& inflow, Faults& faults) {
  inflow.place = table.place.text();
  const int n_given = (inflow.flow_rate ? 1 : 0) + (inflow.speed ? 1 : 0) + (table.find("key_frames") ? 1 : 0) +
                      (inflow.key_frames_file.empty() ? 0 : 1);
  if (n_given != 1)
    faults.add(table.place, fmt::format("inflow '{}' needs exactly one of 'flow_rate', 'speed', 'key_frames' and "
                                        "'key_frames_file'; it has {}",
                                        inflow.name, n_given));
  if (inflow.profile != FeedProfile::plug && std::holds_alternative<ShapeSection>(inflow.section))
    faults.add(table.find("profile")->place,
               fmt::format("'{}.profile' is \"poiseuille\", which sections of type \"disc\" and \"rectangle\" have and "
                           "those of type \"shape\" do not; it must be \"plug\"",
                           table.path));
  const bool by_frames = table.find("key_frames") || !inflow.key_frames_file.empty();
  for (const char* key : {"position", "end", "moves_with"})
    if (by_frames && table.find(key))
      faults.add(table.find(key)->place,
                 fmt::format("'{}.{}' is not for an inflow with key frames, which say it", table.path, key));
  if (!by_frames && !table.find("position"))
    faults.add(table.place, fmt::format("'{}' lacks the key 'position'", table.path));
  if (const Value* frames = table.find("key_frames"))
    if (const std::string fault = key_frames_fault(inflow.key_frames); !fault.empty())
      faults.add(frames->place, fmt::format("'{}' {}", frames->path, fault));
  if (!(inflow.direction.norm() > 0.0))
    faults.add(table.find("direction")->place,
               fmt::format("'{}.direction' has no length; it must not be [0, 0, 0]", table.path));
  else if (!inflow.side.isZero(0.0) &&
           !(inflow.side.cross(inflow.direction).norm() > 1e-9 * inflow.side.norm() * inflow.direction.norm()))
    faults.add(table.find("side")->place, fmt::format("'{}.side' must not be along 'direction'", table.path));
  if (inflow.end && !(*inflow.end > inflow.start))
    faults.add(table.find("end")->place,
               fmt::format("'{}.end' is {:g}; it must be later than 'start', {:g}", table.path, *inflow.end, inflow.start));
}

/// The inflow with the material's number and density.
void assign_material(const Value& table, const Scene& scene, Inflow& inflow, Faults& faults) {
  std::vector<std::string> names;
  for (const NamedMaterial& named : scene.materials) names.push_back(named.name);
  const auto found = std::find(names.begin(), names.end(), inflow.material);
  if (found == names.end()) {
    faults.add(table.find("material")->place,
               fmt::format("inflow '{}' is made of '{}', which is not in [materials]{}", inflow.name, inflow.material,
                           config::suggestion(inflow.material, names)));
    return;
  }
  const auto index = static_cast<std::size_t>(found - names.begin());
  inflow.material_index = static_cast<std::uint8_t>(index);
  const Material& material = scene.materials[index].material;
  inflow.density = rest_density(material);
  if (inflow.pressure.value == 0.0 && !inflow.pressure.is_measured) return;
  const std::optional<VolumetricLaw> law = volumetric_law(material);
  if (!law) {
    faults.add(table.find("pressure")->place,
               fmt::format("'{}.pressure' needs a law that keeps the pressure apart, and that of '{}' does not", table.path,
                           inflow.material));
    return;
  }
  if (inflow.pressure.is_measured) {
    inflow.wave_speed =
        std::visit([](const auto& l) { return std::sqrt(l.wave_speed_squared(state_at_rest(l))); }, material);
    return;
  }
  double low = 0.01, high = 1.0;  // the pressure falls with J
  if (!(-law->stress(low) > inflow.pressure.value)) {
    faults.add(table.find("pressure")->place,
               fmt::format("'{}.pressure' is {:g}, which squeezes '{}' to less than a hundredth of its volume", table.path,
                           inflow.pressure.value, inflow.material));
    return;
  }
  for (int n = 0; n < 200; ++n) (-law->stress(0.5 * (low + high)) > inflow.pressure.value ? low : high) = 0.5 * (low + high);
  inflow.volume_ratio = 0.5 * (low + high);
}

}  // namespace

config::Names<FeedProfile> names(config::Of<FeedProfile>) {
  return {{"plug", FeedProfile::plug}, {"poiseuille", FeedProfile::poiseuille}};
}

const Keys<DiscSection>& keys(config::Of<DiscSection>) {
  static const auto table =
      Keys<DiscSection>("A disc about the axis.", {0.0}).key("radius", &DiscSection::radius, length_rule("Radius."));
  return table;
}

const Keys<RectangleSection>& keys(config::Of<RectangleSection>) {
  static const auto table = Keys<RectangleSection>("A rectangle about the axis.", {0.0, 0.0})
                                .key("width", &RectangleSection::width, length_rule("Length along `side`."))
                                .key("height", &RectangleSection::height, length_rule("Length across `side`."));
  return table;
}

const Keys<ShapeSection>& keys(config::Of<ShapeSection>) {
  static const auto table =
      Keys<ShapeSection>(
          "What the plane z = 0 cuts out of a shape: x along `side`, y across both it and `direction`, the axis at 0.", {})
          .key("shape", &ShapeSection::shape, {.about = "The shape, with finite bounds.", .required = true});
  return table;
}

const Keys<Inflow>& keys(config::Of<Inflow>) {
  static const auto table =
      Keys<Inflow>(
          "A nozzle from which material enters ([page](processes.md)). Its last three cells before the exit, four with the "
          "cubic spline, are full of particles that move with it, so there must be room for them in the domain. "
          "`history.csv` counts what has entered.")
          .key("name", &Inflow::name,
               {.about = "Name in messages and columns; different for each inflow.", .required = true})
          .key("material", &Inflow::material, {.about = "Name of an entry of [materials].", .required = true})
          .key("section", &Inflow::section, {.about = "Cross-section of the nozzle.", .required = true})
          .key("position", &Inflow::position,
               {.about = "Centre of the exit, at t = 0 where the inflow moves with a collider.",
                .unit = "m",
                .default_text = "by key frames"})
          .key("direction", &Inflow::direction,
               {.about = "Direction of the flow; the length does not matter but may not be 0."})
          .key("side", &Inflow::side,
               {.about = "Direction of a rectangle's width, or of a shape's x, as far as it is across `direction`.",
                .default_text = "x, or y"})
          .key("flow_rate", &Inflow::flow_rate,
               {.about = "Volume that enters in a second.",
                .unit = "m^3/s",
                .range = config::at_least(0.0),
                .default_text = "none"})
          .key("speed", &Inflow::speed,
               {.about = "Speed of the material in the exit, in the mean over the section.",
                .unit = "m/s",
                .range = config::at_least(0.0),
                .default_text = "none"})
          .key(
              "profile", &Inflow::profile,
              {.about =
                   "Speed over the section. plug: everywhere the same; poiseuille: that of a Newtonian fluid far from the "
                   "ends of a tube, in a disc or a rectangle; ends of a rectangle that lie on slip or periodic faces of the "
                   "domain have no wall."})
          .key("key_frames", &Inflow::key_frames,
               {.about = "Instead of `position` and a rate: where the exit is and the volume that has entered by then, in "
                         "s, m and m^3; linear between.",
                .default_text = "none"})
          .key("key_frames_file", &Inflow::key_frames_file,
               {.about = "The same as a CSV file with the columns t, x, y, z, e.", .default_text = "none"})
          .key("start", &Inflow::start, {.about = "When it begins.", .unit = "s", .range = config::at_least(0.0)})
          .key("end", &Inflow::end, {.about = "When it ends.", .unit = "s", .default_text = "never"})
          .key("pressure", &Inflow::pressure,
               {.about = "Pressure at which the material enters; 0: free of stress; measured: that in front of the exit.",
                .unit = "Pa",
                .range = config::at_least(0.0)})
          .key("particles_per_cell", &Inflow::particles_per_cell,
               {.about = "Particles in a full grid cell, as of a body.", .choices = {1, 8, 27, 64}})
          .key("moves_with", &Inflow::moves_with,
               {.about = "Name of a collider whose motion carries the nozzle along.", .default_text = "none"})
          .check(check_inflow);
  return table;
}

void join_inflows(const Value& root, Scene& scene, Faults& faults) {
  const Value* list = root.find("inflows");
  if (!list) return;
  std::vector<std::string> names, columns;
  for (const Collider& collider : scene.colliders) names.push_back(collider.name);
  for (const Collider& collider : scene.colliders) columns.push_back(column_prefix(collider.name));
  for (const RigidBody& body : scene.rigid_bodies) columns.push_back(column_prefix(body.name));
  for (std::size_t i = 0; i < scene.inflows.size(); ++i) {
    Inflow& inflow = scene.inflows[i];
    const Value& table = list->items[i];
    assign_material(table, scene, inflow, faults);
    if (std::find(columns.begin(), columns.end(), column_prefix(inflow.name)) != columns.end())
      faults.add(
          table.find("name")->place,
          fmt::format("'{}.name' is \"{}\", which a collider or a rigid body has already: their columns in history.csv "
                      "would have the same names",
                      table.path, inflow.name));
    if (const auto* rectangle = std::get_if<RectangleSection>(&inflow.section);
        rectangle && inflow.position && !inflow.moves_with && inflow.direction.norm() > 0.0) {
      const SectionFrame frame = section_frame(inflow);
      inflow.open_ends = open_ends(scene.grid, scene.faces, *rectangle, *inflow.position, frame.first, frame.second);
    }
    if (!inflow.moves_with) continue;
    const auto found = std::find(names.begin(), names.end(), *inflow.moves_with);
    if (found == names.end())
      faults.add(table.find("moves_with")->place,
                 fmt::format("'{}.moves_with' is \"{}\", which is no collider{}", table.path, *inflow.moves_with,
                             config::suggestion(*inflow.moves_with, names)));
  }
}

namespace config {

bool Codec<TimeFormula>::read(const Value& value, const Rule& rule, TimeFormula& out, Faults& faults) {
  out = {};
  if (value.kind != Kind::text) return read_number(value, rule, out.number, faults);
  try {
    const Formula formula(value.text, {"t"});
  } catch (const UsageError& error) {
    faults.add(value.place, fmt::format("'{}' is no formula of t: \"{}\": {}", value.path, value.text, error.what()));
    return false;
  }
  out.text = value.text;
  return true;
}

Value Codec<TimeFormula>::write(const TimeFormula& formula) {
  return formula.text.empty() ? make_number(formula.number) : make_text(formula.text);
}

bool Codec<FeedPressure>::read(const Value& value, const Rule& rule, FeedPressure& out, Faults& faults) {
  out = {};
  if (value.kind != Kind::text) return read_number(value, rule, out.value, faults);
  out.is_measured = value.text == "measured";
  if (!out.is_measured)
    faults.add(value.place,
               fmt::format("'{}' is \"{}\"; it must be a number of Pa or \"measured\"", value.path, value.text));
  return out.is_measured;
}

Value Codec<FeedPressure>::write(const FeedPressure& pressure) {
  return pressure.is_measured ? make_text("measured") : make_number(pressure.value);
}

bool Codec<Section>::read(const Value& value, const Rule&, Section& out, Faults& faults) {
  return section_types().read(value, out, faults);
}

Value Codec<Section>::write(const Section& section) { return section_types().write(section); }

void Codec<Section>::describe(const std::string& path, std::vector<TableText>& out) {
  section_types().describe("Sections", path, out);
}

bool Codec<std::vector<FeedFrame>>::read(const Value& value, const Rule&, std::vector<FeedFrame>& out, Faults& faults) {
  const auto refuse = [&](const Value& where) {
    faults.add(where.place, fmt::format("'{}' must be a list of five numbers t, x, y, z, e", where.path));
    return false;
  };
  if (!value.is_list()) {
    faults.add(value.place, fmt::format("'{}' must be a list of [t, x, y, z, e]; it is {}", value.path, in_words(value)));
    return false;
  }
  out.clear();
  for (const Value& row : value.items) {
    if (!row.is_list() || row.items.size() != 5) return refuse(row);
    double v[5];
    for (std::size_t c = 0; c < 5; ++c)
      if (!read_number(row.items[c], {}, v[c], faults)) return false;
    out.push_back({v[0], {v[1], v[2], v[3]}, v[4]});
  }
  return true;
}

Value Codec<std::vector<FeedFrame>>::write(const std::vector<FeedFrame>& frames) {
  if (frames.empty()) return {};
  std::vector<Value> rows;
  for (const FeedFrame& frame : frames) {
    std::vector<Value> row;
    for (const double number : {frame.time, frame.position[0], frame.position[1], frame.position[2], frame.volume})
      row.push_back(make_number(number));
    rows.push_back(make_list(std::move(row)));
  }
  return make_list(std::move(rows));
}

}  // namespace config
}  // namespace bulkley
