#include "scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "bulkley/base/error.hpp"
#include "bulkley/config/keys.hpp"
#include "config/nearest.hpp"
#include "geometry/builtin_mesh.hpp"
#include "geometry/mesh_shape.hpp"
#include "grid/floors.hpp"
#include "kernel/stress_update.hpp"
#include "material/material_keys.hpp"
#include "scene/body_keys.hpp"
#include "scene/boundary_keys.hpp"
#include "scene/gauge_keys.hpp"
#include "scene/grid_keys.hpp"
#include "scene/inflow_keys.hpp"
#include "scene/magnetics_keys.hpp"
#include "scene/output_keys.hpp"
#include "scene/partition_keys.hpp"
#include "scene/rigid_body_keys.hpp"
#include "scene/time_step_keys.hpp"
#include "scene/transfer_keys.hpp"

namespace bulkley {
namespace {

using config::Faults;
using config::Value;

/// Gives each body its material's index and density.
void assign_materials(const Value& root, Scene& scene, Faults& faults) {
  std::vector<std::string> names;
  for (const NamedMaterial& named : scene.materials) names.push_back(named.name);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    Body& body = scene.bodies[b];
    const auto found = std::find(names.begin(), names.end(), body.material);
    if (found == names.end()) {
      const Value& value = *root.find("bodies")->items[b].find("material");
      faults.add(value.place, fmt::format("body '{}' is made of '{}', which is not in [materials]{}", body.name,
                                          body.material, config::suggestion(body.material, names)));
      continue;
    }
    const auto index = found - names.begin();
    body.material_index = static_cast<std::uint8_t>(index);
    body.density = rest_density(scene.materials[static_cast<std::size_t>(index)].material);
  }
}

/// Entries of a list of tables must have different names.
void require_different_names(const Value& root, const char* list_key, Faults& faults) {
  const Value* list = root.find(list_key);
  if (!list) return;
  std::set<std::string> seen;
  for (const Value& entry : list->items) {
    const Value* name = entry.find("name");
    if (!seen.insert(name->text).second)
      faults.add(name->place,
                 fmt::format("'{}' is \"{}\", which another entry of [{}] has already", name->path, name->text, list_key));
  }
}

/// What a field needs that is no matter of a law; `by_default`: frames hold it then, unless the scene lists their fields.
struct Need {
  bool met;
  const char* what;
  bool by_default;
};
std::optional<Need> need_of(Field field, const Scene& scene) {
  const TimeStepSettings& time = scene.time_stepping;
  if (field == Field::cell_mean_stress)  // the derived field `pressure` contains it
    return Need{time.integrator == IntegratorKind::imex, "time.integrator = \"imex\"", false};
  if (field == Field::layer_pressure)
    return Need{lies_on_floors(scene) && time.integrator == IntegratorKind::explicit_step,
                "transfer.close_voids or transfer.thin_layers, the explicit step, a floor and a fluid", false};
  if (field == Field::viscous_stress)
    return Need{time.viscosity == ViscosityKind::implicit_stress, "time.viscosity = \"implicit\"", false};
  if (field == Field::magnetic_force) return Need{scene.magnetics.has_value(), "[magnetics]", true};
  if (field == Field::magnetic_field || field == Field::magnetisation)
    return Need{scene.magnetics.has_value(), "[magnetics]", false};
  return {};
}

/// Frames hold the internal variables of the scene's laws, unless the scene lists their fields.
void choose_frame_fields(const Value& root, Scene& scene, Faults& faults) {
  const OptionalFields present = internal_fields(scene.materials);
  const Value* output = root.find("output");
  const Value* given = output ? output->find("fields") : nullptr;
  for (const FieldInfo& field : field_table) {
    if (!field.optional || !field.written || field.field == Field::kirchhoff_stress) continue;  // every law has a stress
    const bool listed =
        std::find(scene.output.fields.begin(), scene.output.fields.end(), field.name) != scene.output.fields.end();
    if (const auto needs = need_of(field.field, scene)) {
      if (!needs->met && listed)
        faults.add(given->place,
                   fmt::format("'output.fields' names '{}', which needs {} ({})", field.name, needs->what, field.meaning));
      if (!given && needs->met && needs->by_default) scene.output.fields.emplace_back(field.name);
      continue;
    }
    if (!given && present.contains(field.field)) scene.output.fields.emplace_back(field.name);
    if (given && listed && !present.contains(field.field))
      faults.add(given->place, fmt::format("'output.fields' names '{}', which no law among the scene's materials has ({})",
                                           field.name, field.meaning));
  }
}

/// As many frames as a run can count, in files.
void check_frame_count(const Value& root, const Scene& scene, Faults& faults) {
  constexpr double most_frames = 1e6;
  const double interval = scene.output.frame_interval, end = scene.time_stepping.end_time;
  if (interval == 0.0 || end / interval <= most_frames) return;
  faults.add(root.find("output")->find("frame_interval")->place,
             fmt::format("'output.frame_interval' is {}; it must be at least {:g}, or there are more than {:g} frames until "
                         "'time.end' = {}",
                         interval, end / most_frames, most_frames, end));
}

/// What several tables have to agree on, and the members that follow from several tables.
void join_tables(const Value& root, Scene& scene, Faults& faults) {
  scene.grid.order = scene.transfer.order;
  for (std::size_t axis = 0; axis < 3; ++axis) scene.grid.periodic[axis] = is_periodic(scene.faces, axis);
  check_number_of_cells(*root.find("domain"), scene.grid, faults);
  if (scene.bodies.empty() && scene.inflows.empty())
    faults.add(root.find("bodies") ? root.find("bodies")->place : root.place,
               "'bodies' is empty; a scene needs at least one body or inflow");
  require_different_names(root, "bodies", faults);
  require_different_names(root, "colliders", faults);
  require_different_names(root, "rigid_bodies", faults);
  join_rigid_bodies(root, scene, faults);
  require_different_names(root, "inflows", faults);
  assign_materials(root, scene, faults);
  join_inflows(root, scene, faults);
  check_frame_count(root, scene, faults);
  join_magnetics(root, scene, faults);  // before the fields, which need its laws
  choose_frame_fields(root, scene, faults);
  join_measurements(root, scene, faults);
  if (const Value* bodies = root.find("bodies"))
    for (const Value& body : bodies->items) scene.body_places.push_back(body.place.text());
  if (const Value* colliders = root.find("colliders"))
    for (const Value& collider : colliders->items) scene.collider_places.push_back(collider.place.text());
}

const config::Keys<Scene>& scene_keys() {
  static const auto table =
      config::Keys<Scene>("Keys before the first table.")
          .key("title", &Scene::title, {.about = "Human-readable title."})
          .key("gravity", &Scene::gravity, {.about = "Acceleration of gravity.", .unit = "m/s^2"})
          .key(
              "acceleration_field", &Scene::acceleration_field,
              {.about =
                   "Body force per mass as formulas of the position in m and the time t in s, added to `gravity`. It has no "
                   "potential; history.csv has its work in a column of its own.",
               .unit = "m/s^2",
               .names = {"x", "y", "z", "t"},
               .default_text = "none"})
          .key("allow_overlap", &Scene::allow_overlap,
               {.about = "Whether bodies may overlap; a point in several bodies belongs to the first of them."})
          .key("domain", &Scene::grid, {.about = "Box and grid.", .required = true})
          .key("time", &Scene::time_stepping, {.about = "Duration and time step.", .required = true})
          .key("transfer", &Scene::transfer, {.about = "Particle-grid transfer."})
          .key("materials", &Scene::materials, {.about = "Materials by name.", .required = true})
          .key("magnetics", &Scene::magnetics, {.about = "Magnetic fields.", .default_text = "none"})
          .key("bodies", &Scene::bodies,
               {.about = "Pieces of material at the start; at least one, or an inflow.", .default_text = "none"})
          .key("inflows", &Scene::inflows, {.about = "Nozzles from which material enters.", .default_text = "none"})
          .key("colliders", &Scene::colliders, {.about = "Rigid obstacles, fixed or moving.", .default_text = "none"})
          .key("rigid_bodies", &Scene::rigid_bodies, {.about = "Free rigid bodies.", .default_text = "none"})
          .key("boundaries", &Scene::faces, {.about = "The faces of the domain."})
          .key("output", &Scene::output, {.about = "Output for visualization and analysis."})
          .key("checkpoint", &Scene::checkpoint, {.about = "Output for restarts."})
          .key("partition", &Scene::partition, {.about = "Domain decomposition."})
          .check(join_tables);
  return table;
}

/// Files of meshes and key frames by absolute paths, so that the effective text finds them from any folder.
void resolve_mesh_files(const std::string& scene_file, Scene& scene) {
  const auto resolved = [&](const Mesh& mesh) {
    Mesh result = mesh;
    const std::filesystem::path folder = std::filesystem::path(scene_file).parent_path();
    if (!mesh.file.starts_with(builtin_prefix))
      result.file = std::filesystem::absolute(folder / mesh.file).lexically_normal().string();
    return result;
  };
  for (Body& body : scene.bodies) body.shape = with_meshes(body.shape, resolved);
  for (Collider& collider : scene.colliders) collider.shape = with_meshes(collider.shape, resolved);
  for (RigidBody& body : scene.rigid_bodies) body.shape = with_meshes(body.shape, resolved);
  for (Inflow& inflow : scene.inflows) {
    if (auto* section = std::get_if<ShapeSection>(&inflow.section)) section->shape = with_meshes(section->shape, resolved);
    if (inflow.key_frames_file.empty()) continue;
    const std::filesystem::path folder = std::filesystem::path(scene_file).parent_path();
    inflow.key_frames_file = std::filesystem::absolute(folder / inflow.key_frames_file).lexically_normal().string();
  }
}

}  // namespace

bool lies_on_floors(const Scene& scene) {
  const auto fills = [](const NamedMaterial& named) { return flows(named.material) && volumetric_law(named.material); };
  const auto yields = [](const NamedMaterial& named) { return has_yield_stress(named.material); };
  const auto sticks = [](const Floor& floor) { return floor.kind == FaceKind::sticky; };
  const TransferSettings& transfer = scene.transfer;
  const std::vector<Floor> floors = floors_of(scene.grid, scene.faces, scene.gravity);
  const bool voids = transfer.close_voids && transfer.dilation != Dilation::particle && std::ranges::any_of(scene.materials, fills);
  const bool layers = transfer.thin_layers && std::ranges::any_of(scene.materials, yields) && std::ranges::any_of(floors, sticks);
  return !floors.empty() && (voids || layers);
}

Scene parse_scene(const std::string& text, const std::string& file_name, const std::vector<std::string>& overrides) {
  Value root = config::parse_toml(text, file_name);
  Faults faults;
  for (const std::string& assignment : overrides) config::apply_override(root, assignment, faults);
  Scene scene;
  scene_keys().read(root, scene, faults);
  faults.throw_if_any();
  scene.warnings = faults.warnings();
  resolve_mesh_files(file_name, scene);
  scene.effective_text = effective_text(scene);
  return scene;
}

std::string effective_text(const Scene& scene) {
  return "# The effective input of a run: every key, defaults included.\n" + config::print_toml(scene_keys().write(scene));
}

std::vector<config::TableText> input_tables() {
  std::vector<config::TableText> sections;
  scene_keys().describe("Top level", "", sections);
  return sections;
}

std::string input_reference() {
  return "# The scene file\n\n"
         "A scene is a TOML file. Units are SI. Every key is listed here; any other key is an error. Where a number is "
         "wanted,\n"
         "an integer will do. `--set key.path=value` on the command line overrides or adds a key; entries of a list go by "
         "index\n"
         "or by name, as in `--set bodies.0.velocity=[0,0,-3]` or `--set bodies.ball.material=pie`.\n\n"
         "Formulas are texts such as `\"sin(2*pi*x)\"`, read by muParser: `+ - * / ^`, comparisons, `&& ||`, `a ? b : c`, "
         "the\n"
         "constant `pi`, and abs, sign, sqrt, exp, ln, log2, log10, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, "
         "tanh,\n"
         "asinh, acosh, atanh, floor, rint, min, max, sum, avg. A formula may name what it works out on the way, each step\n"
         "ending with a comma: `\"r = sqrt(x*x + y*y), r > 0 ? y/r : 0\"`.\n\n"
         "Numbers are finite and no larger than 1e100 in magnitude. A scene file has at most 16 MiB, 500000 values, "
         "brackets 32 "
         "deep\nand formulas of 4000 characters.\n\n"
         "This page is printed by `bulkley input-reference`; do not edit it.\n\n" +
         config::print_reference(input_tables());
}

}  // namespace bulkley
