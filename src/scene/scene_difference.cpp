#include "scene/scene_difference.hpp"

#include <algorithm>
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
  if (path == "title" || path == "time.end") return true;
  const std::string table = path.substr(0, path.find('.'));
  return table == "output" || table == "checkpoint" || table == "partition";
}

const std::string* find(const Leaves& leaves, const std::string& path) {
  const auto found = std::find_if(leaves.begin(), leaves.end(), [&](const auto& leaf) { return leaf.first == path; });
  return found == leaves.end() ? nullptr : &found->second;
}

// As this version would print it, which adds the keys that it has and an older one had not.
std::string brought_up_to_date(const std::string& text) {
  try {
    return parse_scene(text, "scene", {}).effective_text;
  } catch (const UsageError&) {
    return text;
  }
}

}  // namespace

std::vector<std::string> scene_differences(const std::string& before, const Scene& now) {
  if (before == now.effective_text) return {};
  Leaves old_leaves;
  try {
    old_leaves = leaves_of(brought_up_to_date(before));
  } catch (const UsageError&) {
    return {"the scene in the checkpoint cannot be read"};
  }
  const Leaves new_leaves = leaves_of(now.effective_text);
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
