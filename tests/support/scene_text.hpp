#pragma once
// Scene texts for the tests of the scene reader.

#include <string>

#include "bulkley/base/error.hpp"
#include "scene/scene.hpp"

namespace bulkley::scene_test {

/// A scene without fault; the line numbers in the tests count its lines.
inline const std::string small_scene =
    "[domain]\n"                                                                 // 1
    "lower = [0, 0, 0]\n"                                                        // 2
    "upper = [1, 1, 0.5]\n"                                                      // 3
    "cell_size = 0.05\n"                                                         // 4
    "[time]\n"                                                                   // 5
    "end = 1\n"                                                                  // 6
    "[materials.fluid]\n"                                                        // 7
    "preset = \"cream\"\n"                                                       // 8
    "[[bodies]]\n"                                                               // 9
    "name = \"ball\"\n"                                                          // 10
    "material = \"fluid\"\n"                                                     // 11
    "shape = { type = \"sphere\", center = [0.5, 0.5, 0.25], radius = 0.2 }\n";  // 12

/// `text` with its first `old` replaced.
inline std::string with(std::string text, const std::string& old, const std::string& replacement) {
  return text.replace(text.find(old), old.size(), replacement);
}

/// The faults of a scene, one per line; "" if there are none.
inline std::string faults_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse_scene(text, "s.toml", overrides);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

inline Scene parsed(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_scene(text, "s.toml", overrides);
}

/// small_scene with another table [materials.fluid]; `lines` start at line 8.
inline std::string with_material(const std::string& lines) { return with(small_scene, "preset = \"cream\"\n", lines); }

/// small_scene with another shape of the body, on line 12.
inline std::string with_shape(const std::string& shape) {
  return with(small_scene, "{ type = \"sphere\", center = [0.5, 0.5, 0.25], radius = 0.2 }", shape);
}

}  // namespace bulkley::scene_test
