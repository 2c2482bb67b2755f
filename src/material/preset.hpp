#pragma once
// Materials that scenes can ask for by name.

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "material/material.hpp"

namespace bulkley {

/// How far the numbers of a preset can be trusted.
enum class Confidence {
  published,  ///< as its source gives them
  measured,   ///< flow curve fitted to a published measurement
  uncertain,  ///< from memory, second hand, or an intermediate result of its source
  proposed,   ///< chosen here, for want of a source
};

struct Preset {
  std::string_view name;
  Material material;
  Confidence confidence;
  std::string_view source;                          ///< where the numbers come from, and which are not from there
  std::optional<Magnetisation> magnetisation = {};  ///< of a magnetic material
};

/// All presets, in alphabetical order. Not collective.
std::span<const Preset> presets();

/// The preset of that name, if there is one. Not collective.
std::optional<Preset> find_preset(std::string_view name);

/// "cream, oobleck, pie": for messages. Not collective.
std::string preset_names();

/// "published", "measured", "uncertain" or "proposed". Not collective.
const char* name(Confidence confidence);

/// What to tell a user of the preset; empty for numbers that are published or measured. Not collective.
std::string caveat(const Preset& preset);

/// The page docs/materials/presets.md: every preset with its law, numbers, confidence and source. Not collective.
std::string preset_reference();

}  // namespace bulkley
