#pragma once
// The options of `bulkley rheometer`, and which of them go together.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "rheometer/fit.hpp"

namespace bulkley {

/// As given on the command line; what was not given is empty and has the default of the mode.
struct RheometerOptions {
  std::string scene, material, preset;
  std::vector<std::string> overrides;
  std::string mode = "shear";
  std::string rates, stresses, amplitudes, frequencies, durations;
  std::optional<double> strain, duration, strain_per_step, largest_strain, tolerance;
  std::optional<int> points;
  double pressure = 0.0;        ///< Pa
  std::optional<double> field;  ///< A/m
  std::string fields;
  std::string out, plot;

  std::string fit;  ///< a file: fit instead of measure
  std::string weights = "relative", range, name;
  std::vector<std::string> fixed;  ///< "yield_stress=0"
  double density = 1000.0;         ///< kg/m^3
  double speed = 1.0;              ///< m/s
};

/// Declares the options; `options` must live until they are parsed. Not collective.
void declare_rheometer_options(CLI::App& app, RheometerOptions& options);

/// Throws UsageError, one sentence, when an option was given that the mode (or the fit) does not use, or when the mode is
/// unknown. Not collective.
void check_rheometer_options(const CLI::App& app, const RheometerOptions& options);

/// Throws UsageError where --weights, --range or --fix cannot be read. Not collective.
rheometer::FitSettings fit_settings(const RheometerOptions& options);

}  // namespace bulkley
