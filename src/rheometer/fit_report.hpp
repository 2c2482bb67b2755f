#pragma once
// A fit as text, and as a material for a scene.

#include <string>

#include "rheometer/fit.hpp"
#include "rheometer/table.hpp"

namespace bulkley::rheometer {

/// Properties of a material that a flow curve does not contain, if the user knows them.
struct Suggestions {
  std::string name;         ///< of the material in the scene
  double density = 1000.0;  ///< kg/m^3
  double speed = 1.0;       ///< m/s, the largest that the scene will see
};

/// Both conventions with standard errors, the quality of the fit, the residuals and the warnings. Not collective.
std::string fit_text(const Fit& fit, const FitSettings& settings);

/// A table [materials.NAME] to paste into a scene. Density, bulk modulus and shear modulus are marked as suggestions: the
/// bulk modulus density (10 speed)^2 keeps changes of density below a percent, the shear modulus is 20 times the largest
/// stress. Not collective.
std::string scene_snippet(const Fit& fit, const Suggestions& suggestions);

/// Columns shear_rate, stress, fitted_stress, relative_residual. Not collective.
Table fit_table(const Fit& fit);

/// A name that TOML takes without quotes, from a file's path: "a/chocolate 23C.csv" gives "chocolate_23C". Not collective.
std::string material_name(const std::string& path);

}  // namespace bulkley::rheometer
