#include "scene/magnetics_keys.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>

#include "bulkley/base/error.hpp"
#include "config/nearest.hpp"
#include "scene/petsc_option_keys.hpp"
#include "scene/scene.hpp"
#include "scene/shape_keys.hpp"

namespace bulkley {
namespace {

using config::Faults;
using config::Keys;
using config::Value;

using Kind = decltype(FieldSource::kind);

const std::vector<std::string> shared_names = {"amplitude", "moves_with"};

const config::Choice<Kind>& kinds() {
  static const auto choice = config::Choice<Kind>("kind")
                                 .add<UniformField>("uniform")
                                 .add<Dipole>("dipole")
                                 .add<BoxMagnet>("box_magnet")
                                 .add<CylinderMagnet>("cylinder_magnet")
                                 .add<Coil>("coil")
                                 .add<FieldFormula>("formula");
  return choice;
}

/// The keys that any source may carry.
struct SharedInput {
  std::string amplitude = "1";
  std::optional<std::string> moves_with;
};

const Keys<SharedInput>& shared_keys() {
  static const auto table =
      Keys<SharedInput>("Keys of sources of any kind.")
          .key("amplitude", &SharedInput::amplitude,
               {.about = "Factor of the source's field, a formula of the time t in s."})
          .key("moves_with", &SharedInput::moves_with,
               {.about = "Name of a collider whose motion carries the source along.", .default_text = "none"})
          .check([](const Value& given, SharedInput& input, Faults& faults) {
            try {
              const Formula read(input.amplitude, {"t"});
            } catch (const UsageError& error) {
              faults.add(given.find("amplitude")->place, fmt::format("'{}.amplitude' is no formula of t: \"{}\": {}",
                                                                     given.path, input.amplitude, error.what()));
            }
          });
  return table;
}

void require_length(const Value& table, const char* key, const Vec3& vector, Faults& faults) {
  if (!(vector.norm() > 0.0))
    faults.add(table.find(key)->place, fmt::format("'{}.{}' has no length; it must not be [0, 0, 0]", table.path, key));
}

/// The keys of everything that has a place and an axis.
template <class Source>
Keys<Source> placed_keys(const std::string& about) {
  return Keys<Source>(about)
      .key("center", &Source::center, {.about = "Centre.", .unit = "m", .required = true})
      .key("axis", &Source::axis, {.about = "Direction of its moment; the length does not matter but may not be 0."})
      .check([](const Value& table, Source& source, Faults& faults) { require_length(table, "axis", source.axis, faults); });
}

const config::Rule remanence_rule = {
    .about = "Remanence B_r of the magnet; negative: poles exchanged.", .unit = "T", .required = true};

}  // namespace

config::Names<FarField> names(config::Of<FarField>) {
  return {{"robin", FarField::robin}, {"zero", FarField::zero}, {"neumann", FarField::neumann}};
}
config::Names<Mixing> names(config::Of<Mixing>) {
  return {{"spheres", Mixing::spheres}, {"linear", Mixing::linear}, {"layers", Mixing::layers}};
}
config::Names<EdgeMean> names(config::Of<EdgeMean>) {
  return {{"harmonic", EdgeMean::harmonic}, {"arithmetic", EdgeMean::arithmetic}};
}

config::Names<FieldSolver> names(config::Of<FieldSolver>) {
  return {{"own", FieldSolver::own}, {"petsc", FieldSolver::petsc}};
}

const Keys<UniformField>& keys(config::Of<UniformField>) {
  static const auto table =
      Keys<UniformField>("The same field everywhere.")
          .key("field", &UniformField::field,
               {.about = "H as formulas of the time t in s.", .unit = "A/m", .names = {"t"}, .required = true});
  return table;
}

const Keys<Dipole>& keys(config::Of<Dipole>) {
  static const auto table =
      placed_keys<Dipole>("A magnet that is small next to its distance.")
          .key("moment", &Dipole::moment, {.about = "Magnetic moment.", .unit = "A m^2", .required = true});
  return table;
}

const Keys<BoxMagnet>& keys(config::Of<BoxMagnet>) {
  static const auto table =
      placed_keys<BoxMagnet>("A block with a uniform magnetisation along its axis.")
          .key("side", &BoxMagnet::side,
               {.about = "Direction of its first side, as far as it is across the axis.", .default_text = "x, or y"})
          .key("sizes", &BoxMagnet::sizes,
               {.about = "Lengths along `side`, across both, and along `axis`, each > 0.", .unit = "m", .required = true})
          .key("remanence", &BoxMagnet::remanence, remanence_rule)
          .check([](const Value& given, BoxMagnet& box, Faults& faults) {
            require_length(given, "axis", box.axis, faults);
            if (!(box.sizes.minCoeff() > 0.0))
              faults.add(given.find("sizes")->place, fmt::format("'{}.sizes' must be greater than 0", given.path));
            if (!box.side.isZero(0.0) && !(box.side.cross(box.axis).norm() > 1e-9 * box.side.norm() * box.axis.norm()))
              faults.add(given.find("side")->place, fmt::format("'{}.side' must not be along 'axis'", given.path));
          });
  return table;
}

const Keys<CylinderMagnet>& keys(config::Of<CylinderMagnet>) {
  static const auto table = placed_keys<CylinderMagnet>("A cylinder with a uniform magnetisation along its axis.")
                                .key("radius", &CylinderMagnet::radius, length_rule("Radius."))
                                .key("length", &CylinderMagnet::length, length_rule("Length along the axis."))
                                .key("remanence", &CylinderMagnet::remanence, remanence_rule);
  return table;
}

const Keys<Coil>& keys(config::Of<Coil>) {
  static const auto table =
      placed_keys<Coil>("A thin ring of current.")
          .key("radius", &Coil::radius, length_rule("Radius."))
          .key("current", &Coil::current,
               {.about = "Current times turns, counter-clockwise about the axis.", .unit = "A", .required = true});
  return table;
}

const Keys<FieldFormula>& keys(config::Of<FieldFormula>) {
  static const auto table =
      Keys<FieldFormula>("A field by formulas; without divergence and curl wherever there is magnetic material.")
          .key("field", &FieldFormula::field,
               {.about = "H as formulas of the position in m and the time t in s.",
                .unit = "A/m",
                .names = {"x", "y", "z", "t"},
                .required = true});
  return table;
}

const Keys<MagneticsSettings>& keys(config::Of<MagneticsSettings>) {
  constexpr auto tolerance = config::strictly_between(0.0, 1.0);
  static const auto table =
      Keys<MagneticsSettings>(
          "The magnetic field: magnets and coils, and what magnetic materials make of their field. It is solved for on a "
          "box of nodes "
          "around the bodies.")
          .key("air", &MagneticsSettings::air,
               {.about = "Air around the magnetic bodies on each side, in extents of these bodies.",
                .range = config::at_least(0.25)})
          .key("origin", &MagneticsSettings::origin,
               {.about = "Origin of the far field's dipole.",
                .unit = "m",
                .default_text = "centroid of the magnetic material at the start"})
          .key("boundary", &MagneticsSettings::boundary,
               {.about = "Far field: robin, falling as that of a dipole; zero, no potential; neumann, no flux."})
          .key("mixing", &MagneticsSettings::mixing,
               {.about = "Permeability of nodes that are filled in part: as a dilution of spheres, linear, or as layers "
                         "along the surface, "
                         "which is the most accurate by far on tractions and torques and takes longer."})
          .key("edges", &MagneticsSettings::edges, {.about = "Permeability between two nodes: which mean of theirs."})
          .key("tolerance", &MagneticsSettings::tolerance,
               {.about = "Largest residual over the largest right side.", .range = tolerance})
          .key("picard_tolerance", &MagneticsSettings::picard_tolerance,
               {.about = "Largest relative change of a permeability in the last sweep.", .range = tolerance})
          .key("picard_limit", &MagneticsSettings::picard_limit,
               {.about = "Most sweeps of a nonlinear law.", .range = config::at_least(1.0)})
          .key("resolve_distance", &MagneticsSettings::resolve_distance,
               {.about = "Distance that the fastest particle may travel between two solves.",
                .unit = "cells",
                .range = config::above(0.0)})
          .key("largest_interval", &MagneticsSettings::largest_interval,
               {.about = "Longest time between two solves while a source changes; required where one does. 0: no limit.",
                .unit = "s",
                .range = config::at_least(0.0)})
          .key("solver", &MagneticsSettings::solver,
               {.about =
                    "Own conjugate gradients, with which results are the same bits on any number of ranks, or a solver of "
                    "PETSc, with which they agree to the tolerance only."})
          .key("petsc_options", &MagneticsSettings::petsc_options,
               {.about = "Options of PETSc's solver, such as `\"-magnetics_mg_levels_pc_type sor\"`."})
          .only_with("solver = \"petsc\"", [](const MagneticsSettings& s) { return s.solver == FieldSolver::petsc; })
          .key("sources", &MagneticsSettings::sources, {.about = "Magnets, coils and far poles.", .required = true})
          .check([](const Value& given, MagneticsSettings& settings, Faults& faults) {
            if (const std::string fault =
                    petsc_options_fault(settings.petsc_options, petsc_magnetics_prefix, "magnetics.tolerance says");
                !fault.empty())
              faults.add(given.find("petsc_options")->place,
                         fmt::format("'{}': {}", given.find("petsc_options")->path, fault));
            if (settings.solver == FieldSolver::petsc && settings.mixing == Mixing::layers)
              faults.add(
                  given.find("solver")->place,
                  fmt::format("'{0}.solver' is \"petsc\", which solves for '{0}.mixing' = \"spheres\" and \"linear\" alone",
                              given.path));
          });
  return table;
}

namespace {

/// Gives the sources the motions of the colliders that carry them.
void join_motions(const Value& list, Scene& scene, Faults& faults) {
  std::vector<std::string> names;
  for (const Collider& collider : scene.colliders) names.push_back(collider.name);
  for (std::size_t s = 0; s < list.items.size(); ++s) {
    FieldSource& source = scene.magnetics->sources[s];
    if (!source.moves_with) continue;
    const auto found = std::find(names.begin(), names.end(), *source.moves_with);
    const Value& value = *list.items[s].find("moves_with");
    if (found == names.end())
      faults.add(value.place, fmt::format("'{}' is \"{}\", which is no collider{}", value.path, *source.moves_with,
                                          config::suggestion(*source.moves_with, names)));
    else
      source.motion = scene.colliders[static_cast<std::size_t>(found - names.begin())].motion;
  }
}

/// A magnet is one body in a periodic domain, where its material has images.
void refuse_single_magnets(const Value& list, const Scene& scene, Faults& faults) {
  for (std::size_t s = 0; s < list.items.size(); ++s) {
    const auto& kind = scene.magnetics->sources[s].kind;
    if (std::holds_alternative<UniformField>(kind) || std::holds_alternative<FieldFormula>(kind)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (scene.grid.periodic[axis])
        faults.add(list.items[s].place, fmt::format("{} is not periodic along {} as the domain is; use kind = \"formula\"",
                                                    config::table_name(list.items[s].path), "xyz"[axis]));
  }
}

}  // namespace

void join_magnetics(const Value& root, Scene& scene, Faults& faults) {
  if (!scene.magnetics) {
    if (scene.output.magnetic_field)
      faults.add(root.find("output")->find("magnetic_field")->place, "'output.magnetic_field' needs [magnetics]");
    for (NamedMaterial& named : scene.materials)
      if (const Value* table = root.find("materials")->find(named.name)->find("magnetic"))
        faults.add(table->key_place, fmt::format("[{}] needs [magnetics]", table->path));
      else if (named.magnetisation) {  // of a preset: without a field it is what it is without magnetism
        named.magnetisation.reset();
        named.material = with_field_yield(named.material, {});
      }
    return;
  }
  const Value& magnetics = *root.find("magnetics");
  const bool any = std::ranges::any_of(scene.materials, [](const NamedMaterial& m) { return m.magnetisation.has_value(); });
  if (!any) faults.add(magnetics.place, "[magnetics] needs a material with a table 'magnetic'");
  const Value& list = *magnetics.find("sources");
  if (list.items.empty()) faults.add(list.place, "'magnetics.sources' is empty; it must hold at least one source");
  join_motions(list, scene, faults);
  refuse_single_magnets(list, scene, faults);
  if (scene.magnetics->largest_interval == 0.0 && AppliedField(scene.magnetics->sources).varies())
    faults.add(magnetics.place, "[magnetics] needs 'largest_interval' above 0, because a source changes with time");
}

namespace config {

bool Codec<std::vector<FieldSource>>::read(const Value& value, const Rule&, std::vector<FieldSource>& out, Faults& faults) {
  if (!expect_list_of_tables(value, faults)) return false;
  bool sound = true;
  out.clear();
  for (const Value& table : value.items) {
    FieldSource source;
    source.place = table.place.text();
    SharedInput shared;
    Value rest = make_table();
    rest.path = table.path;
    rest.place = table.place;
    for (const std::string& name : shared_names)
      if (const Value* entry = table.find(name)) rest.items.push_back(*entry);
    sound = kinds().read(table, source.kind, faults, shared_names) && shared_keys().read(rest, shared, faults) && sound;
    source.amplitude = shared.amplitude;
    source.moves_with = shared.moves_with;
    out.push_back(std::move(source));
  }
  return sound;
}

Value Codec<std::vector<FieldSource>>::write(const std::vector<FieldSource>& sources) {
  Value list;
  list.kind = Kind::list;
  for (const FieldSource& source : sources) {
    Value table = kinds().write(source.kind);
    for (Value& entry : shared_keys().write({source.amplitude, source.moves_with}).items)
      table.items.push_back(std::move(entry));
    list.items.push_back(std::move(table));
  }
  return list;
}

void Codec<std::vector<FieldSource>>::describe(const std::string& path, std::vector<TableText>& out) {
  kinds().describe("[[" + path + "]]", path, out);
  shared_keys().describe("[[" + path + "]], any kind", path, out);
}

}  // namespace config
}  // namespace bulkley
