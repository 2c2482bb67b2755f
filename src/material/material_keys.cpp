#include "material/material_keys.hpp"

#include <fmt/format.h>

#include <cmath>

#include "bulkley/base/error.hpp"
#include "bulkley/material/plain_keys.hpp"
#include "config/nearest.hpp"
#include "material/law_text.hpp"
#include "material/magnetic_keys.hpp"
#include "material/preset.hpp"

namespace bulkley {
namespace {

using config::Faults;
using config::Value;

std::vector<std::shared_ptr<const AddedLawModel>>& registry() {
  static std::vector<std::shared_ptr<const AddedLawModel>> models;
  return models;
}

/// Calls visit(law) with a default law of each alternative of Material but AddedLaw, which has none.
template <class Visit, std::size_t... I>
void visit_laws(const Visit& visit, std::index_sequence<I...>) {
  const auto visit_own = [&]<class Law>(const Law& law) {
    if constexpr (!std::is_same_v<Law, AddedLaw>) visit(law);
  };
  (visit_own(std::variant_alternative_t<I, Material>{}), ...);
}
template <class Visit>
void visit_laws(const Visit& visit) {
  visit_laws(visit, std::make_index_sequence<std::variant_size_v<Material>>{});
}

std::vector<std::string> law_names() {
  std::vector<std::string> names;
  visit_laws([&](const auto& law) { names.emplace_back(law.law_name); });
  for (const auto& model : registry()) names.emplace_back(model->name());
  return names;
}

/// The law that a table starts from, with NaN or a preset's values in its parameters.
bool starting_point(const Value& table, NamedMaterial& named, Faults& faults) {
  const Value* law = table.find("law");
  const Value* preset = table.find("preset");
  if (law && preset) {
    faults.add(preset->key_place, fmt::format("{} has both 'law' and 'preset'; give one", config::table_name(table.path)));
    return false;
  }
  if (!law && !preset) {
    for (const Value& entry : table.items)
      if (const auto near = config::nearest(entry.key, {"law", "preset"}))
        faults.add(entry.key_place,
                   fmt::format("unknown key '{}' {}; did you mean '{}'?", entry.key, config::in_table(table.path), *near));
    faults.add(table.place, fmt::format("{} needs 'law' or 'preset'", config::table_name(table.path)));
    return false;
  }
  std::vector<std::string> names = law_names();
  if (preset) {
    names.clear();
    for (const Preset& p : presets()) names.emplace_back(p.name);
  }
  std::size_t index = 0;
  if (!config::read_choice(law ? *law : *preset, names, index, faults)) return false;
  if (preset) {
    named.material = presets()[index].material;
    named.magnetisation = presets()[index].magnetisation;
    named.caveat = caveat(presets()[index]);
    return true;
  }
  visit_laws([&](const auto& candidate) {
    if (candidate.law_name == names[index]) named.material = candidate;
  });
  for (const auto& model : registry())
    if (model->name() == names[index]) named.material = AddedLaw{{model}};
  return true;
}

bool read_magnetic(const Value& table, NamedMaterial& named, Faults& faults) {
  MagneticProperties magnetic;
  if (!keys(config::Of<MagneticProperties>{}).read(table, magnetic, faults)) return false;
  named.magnetisation = magnetic.magnetisation;
  named.material = with_field_yield(named.material, {});  // a preset's does not count beside a table
  if (!magnetic.yield.given()) return true;
  if (!takes_field_yield(named.material)) {
    faults.add(table.find("yield")->place, fmt::format("'{}.yield' needs a fluid that yields: law = \"herschel_bulkley\" or "
                                                       "\"thixotropic_herschel_bulkley\"",
                                                       table.path));
    return false;
  }
  named.material = with_field_yield(named.material, magnetic.yield);
  return true;
}

bool read_material(const Value& table, NamedMaterial& named, Faults& faults) {
  if (!config::expect_table(table, faults) || !starting_point(table, named, faults)) return false;
  if (!std::visit([&]<class Law>(Law& law) { return LawText<Law>::read(table, law, faults); }, named.material)) return false;
  const Value* magnetic = table.find("magnetic");
  return !magnetic || read_magnetic(*magnetic, named, faults);
}

Value write_material(const NamedMaterial& named) {
  const Material& material = named.material;
  Value table = config::make_table();
  config::add_entry(table, "law", config::make_text(law_name(material)));
  Value parameters = std::visit([]<class Law>(const Law& law) { return LawText<Law>::write(law); }, material);
  table.comment = parameters.comment;
  for (Value& entry : parameters.items) table.items.push_back(std::move(entry));
  if (named.magnetisation)
    config::add_entry(table, "magnetic",
                      keys(config::Of<MagneticProperties>{}).write({*named.magnetisation, field_yield(material)}));
  return table;
}

}  // namespace

void report_numbers_not_given(const config::Value& table, const config::Value& written, config::Faults& faults) {
  for (const config::Value& entry : written.items)
    if (entry.kind == config::Kind::number && std::isnan(entry.number))
      config::report_missing_key(table, entry.key, false, faults);
}

void add_law_model(std::shared_ptr<const AddedLawModel> model) {
  for (const std::string& name : law_names())
    if (name == model->name()) throw UsageError(fmt::format("add_law: a law named '{}' exists already", name));
  registry().push_back(std::move(model));
}

namespace config {

bool Codec<std::vector<NamedMaterial>>::read(const Value& value, const Rule&, std::vector<NamedMaterial>& out,
                                             Faults& faults) {
  if (!expect_table(value, faults)) return false;
  constexpr std::size_t most = 255;  // a particle stores its material in one byte
  bool sound = true;
  out.clear();
  for (const Value& table : value.items) {
    NamedMaterial named{table.key, {}, {}};
    sound = read_material(table, named, faults) && sound;
    out.push_back(std::move(named));
  }
  if (out.empty() || out.size() > most) {
    faults.add(value.place,
               fmt::format("[{}] names {} materials; it must name between 1 and {}", value.path, out.size(), most));
    return false;
  }
  return sound;
}

Value Codec<std::vector<NamedMaterial>>::write(const std::vector<NamedMaterial>& materials) {
  Value table = make_table();
  for (const NamedMaterial& named : materials) add_entry(table, named.name, write_material(named));
  return table;
}

void Codec<std::vector<NamedMaterial>>::describe(const std::string& path, std::vector<TableText>& out) {
  const std::string title = "[" + path + ".NAME]";
  std::vector<std::string> presets_known;
  const std::string meaning =
      "A material by name, with the keys of its law for what differs; docs/materials/presets.md has their numbers and "
      "sources.";
  for (const Preset& p : presets()) presets_known.emplace_back(p.name);
  const std::string either = "`law` or `preset` is required";
  TableText section{title, "One material; NAME is what bodies call it. At most 255 materials.", {}};
  section.keys.push_back({"law", "name", "", either, allowed_names(law_names()), "The constitutive law.", false});
  section.keys.push_back({"preset", "name", "", either, allowed_names(presets_known), meaning, false});
  add_section(section, out);
  visit_laws([&]<class Law>(const Law&) { LawText<Law>::describe(title + ", law = \"" + Law::law_name + "\"", path, out); });
  keys(config::Of<MagneticProperties>{}).describe("[" + path + ".NAME.magnetic]", path, out);
  for (const auto& model : registry()) model->describe(title + ", law = \"" + model->name() + "\"", path, out);
}

}  // namespace config
}  // namespace bulkley
