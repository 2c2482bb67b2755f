#include "bulkley/material/preset.hpp"

namespace bulkley {

// The numbers are those of the material files behind Bhargava's report "Material Point Method for Simulating Non-Newtonian
// Fluids" (IST Austria), in the convention of Yue et al. (2015): density, bulk_modulus, shear_modulus, sigma_Y, eta, h.
std::span<const Preset> presets() {
  // clang-format off
  static const Preset table[] = {
      {"cream", {{77.7, 1.09e5, 290.0, 31.9, 27.2, 0.22}},
       "Material file of Bhargava's report on MPM for non-Newtonian fluids, figure 7."},
      {"oobleck", {{1000.0, 1.09e5, 1.12e4, 0.1, 10.0, 2.8}},
       "Material file of Bhargava's report on MPM for non-Newtonian fluids, figures 1, 6, 8 and 9."},
      {"pie", {{275.0, 1.09e5, 1600.0, 120.0, 5.0, 0.27}},
       "Material file of Bhargava's report on MPM for non-Newtonian fluids, figures 5 and 8."},
  };
  // clang-format on
  return table;
}

std::optional<Preset> find_preset(std::string_view name) {
  for (const Preset& preset : presets())
    if (preset.name == name) return preset;
  return std::nullopt;
}

std::string preset_names() {
  std::string names;
  for (const Preset& preset : presets()) {
    if (!names.empty()) names += ", ";
    names += preset.name;
  }
  return names;
}

}  // namespace bulkley
