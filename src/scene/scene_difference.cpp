#include "scene/scene_difference.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "bulkley/base/error.hpp"
#include "bulkley/config/toml.hpp"

namespace bulkley {

namespace {

using Leaves = std::vector<std::pair<std::string, std::string>>;  // path and text of the value

bool holds_tables(const config::Value& value) {
  return value.is_table() || (value.is_list() && std::any_of(value.items.begin(), value.items.end(), holds_tables));
}

void collect(const config::Value& value, const std::string& path, Leaves& leaves) {
  if (!holds_tables(value)) {
    leaves.emplace_back(path, config::print_inline(value));
    return;
  }
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    const config::Value& item = value.items[i];
    collect(item, config::child_path(path, value.is_table() ? item.key : fmt::format("{}", i)), leaves);
  }
}

Leaves leaves_of(const std::string& text) {
  Leaves leaves;
  collect(config::parse_toml(text, "scene"), "", leaves);
  return leaves;
}

bool may_change(const std::string& path) {
  if (path == "title" || path == "time.end" || path == "time.step_timeout") return true;
  const std::string table = path.substr(0, path.find('.'));
  return table == "output" || table == "checkpoint" || table == "partition";
}

const std::string* find(const Leaves& leaves, const std::string& path) {
  const auto found = std::find_if(leaves.begin(), leaves.end(), [&](const auto& leaf) { return leaf.first == path; });
  return found == leaves.end() ? nullptr : &found->second;
}

// The constants of a flow as the scene gave them; null for laws that know one convention only.
ShearRheometerConstants* given_flow(Material& material) {
  return std::visit(
      [](auto& law) -> ShearRheometerConstants* {
        if constexpr (requires { law.parameters.given; })
          return &law.parameters.given;
        else
          return nullptr;
      },
      material);
}

// Flows are compared as both scenes give them, or else both in Yue's convention.
void use_one_convention(Scene& before, Scene& now) {
  for (NamedMaterial& old : before.materials)
    for (NamedMaterial& present : now.materials) {
      if (old.name != present.name) continue;
      ShearRheometerConstants* const a = given_flow(old.material);
      ShearRheometerConstants* const b = given_flow(present.material);
      if (a && b && std::isnan(a->flow_index) != std::isnan(b->flow_index)) *a = *b = {};
    }
}

// A complete scene of a version without transfer.dilation, close_voids or thin_layers: its fluids kept their volume particle by particle,
// left voids at floors, which only those know that keep it by cells, and sheared in whole cells, if they had a yield stress.
void use_fluids_of_then(const std::string& before, Scene& old, const Scene& present) {
  const Leaves leaves = leaves_of(before);
  if (!find(leaves, "transfer.scheme")) return;
  const bool yields = std::ranges::any_of(old.materials, [](const NamedMaterial& named) { return has_yield_stress(named.material); });
  if (!find(leaves, "transfer.thin_layers")) old.transfer.thin_layers = !yields && present.transfer.thin_layers;
  const bool fluids = std::ranges::any_of(old.materials, [](const NamedMaterial& named) {
    return flows(named.material) && volumetric_law(named.material).has_value();
  });
  if (!fluids) return;
  const auto is_explicit = [](const Scene& scene) { return scene.time_stepping.integrator == IntegratorKind::explicit_step; };
  if (!find(leaves, "transfer.dilation") && is_explicit(old)) old.transfer.dilation = Dilation::particle;
  const bool by_particles = is_explicit(present) && present.transfer.dilation == Dilation::particle;
  if (!find(leaves, "transfer.close_voids")) old.transfer.close_voids = by_particles && present.transfer.close_voids;
}

// Both scenes as this version prints them, which adds the keys that it has and an older one had not.
std::pair<std::string, std::string> comparable_texts(const std::string& before, const Scene& now) {
  try {
    Scene old = parse_scene(before, "scene", {}), present = now;
    use_one_convention(old, present);
    use_fluids_of_then(before, old, present);
    return {effective_text(old), effective_text(present)};
  } catch (const UsageError&) {
    return {before, now.effective_text};
  }
}

}  // namespace

std::vector<std::string> scene_differences(const std::string& before, const Scene& now) {
  if (before == now.effective_text) return {};
  Leaves old_leaves, new_leaves;
  try {
    const auto [old_text, new_text] = comparable_texts(before, now);
    old_leaves = leaves_of(old_text);
    new_leaves = leaves_of(new_text);
  } catch (const UsageError&) {
    return {"the scene in the checkpoint cannot be read"};
  }
  std::vector<std::string> differences;
  for (const auto& [path, value] : new_leaves) {
    const std::string* old_value = find(old_leaves, path);
    if (may_change(path) || (old_value && *old_value == value)) continue;
    differences.push_back(fmt::format("{}: {} -> {}", path, old_value ? *old_value : "not given", value));
  }
  for (const auto& [path, value] : old_leaves)
    if (!may_change(path) && !find(new_leaves, path)) differences.push_back(fmt::format("{}: {} -> not given", path, value));
  return differences;
}

}  // namespace bulkley
