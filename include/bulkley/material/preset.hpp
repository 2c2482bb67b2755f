#pragma once
// Materials that scenes can ask for by name.

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "bulkley/material/material.hpp"

namespace bulkley {

struct Preset {
  std::string_view name;
  HerschelBulkley material;
  std::string_view source;  ///< where the numbers come from, one sentence
};

/// All presets, in alphabetical order. Not collective.
std::span<const Preset> presets();

/// The preset of that name, if there is one. Not collective.
std::optional<Preset> find_preset(std::string_view name);

/// "cream, oobleck, pie": for messages. Not collective.
std::string preset_names();

}  // namespace bulkley
