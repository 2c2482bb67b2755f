#pragma once
// Keys of [output] and [checkpoint] of a scene.

#include "bulkley/config/keys.hpp"
#include "bulkley/io/settings.hpp"

namespace bulkley {

inline config::Names<FloatPrecision> names(config::Of<FloatPrecision>) {
  return {{"float32", FloatPrecision::float32}, {"float64", FloatPrecision::float64}};
}

/// What a frame can hold beside the position, which it always holds.
inline std::vector<std::string> frame_field_choices() {
  return {"velocity",
          "affine_velocity",
          "left_cauchy_green",
          "volume_ratio",
          "kirchhoff_stress",
          "cauchy_stress",
          "pressure",
          "deviatoric_stress",
          "plastic_shear_rate",
          "plastic_dissipation",
          "density",
          "structure",
          "hardening",
          "plastic_volume_ratio",
          "viscous_left_cauchy_green",
          "mass",
          "reference_volume",
          "material",
          "id"};
}

inline const config::Keys<OutputSettings>& keys(config::Of<OutputSettings>) {
  using S = OutputSettings;
  static const auto table =
      config::Keys<S>("What a run writes to look at.")
          .key("frame_interval", &S::frame_interval,
               {.about = "Simulated time between frames; 0: no frames.", .unit = "s", .range = config::at_least(0.0)})
          .key("history_interval", &S::history_interval,
               {.about = "Steps between rows of history.csv.", .unit = "steps", .range = config::at_least(1.0)})
          .key("progress_interval", &S::progress_interval,
               {.about = "Wall time between progress lines.", .unit = "s", .range = config::at_least(0.0), .duration = true})
          .key("fields", &S::fields, {.about = "What frames hold beside the position.", .names = frame_field_choices()})
          .key("precision", &S::precision, {.about = "Size of the real numbers in frames."})
          .key("grid", &S::grid, {.about = "Also write the grid's mass density and velocity."});
  return table;
}

inline const config::Keys<CheckpointSettings>& keys(config::Of<CheckpointSettings>) {
  using S = CheckpointSettings;
  static const auto table =
      config::Keys<S>("When a run writes a file to restart from; that never changes the result.")
          .key("steps", &S::step_interval,
               {.about = "Steps between checkpoints; 0: not by steps.", .unit = "steps", .range = config::at_least(0.0)})
          .key("wall_time", &S::wall_interval,
               {.about = "Wall time between checkpoints, as a number or like \"10m\" or \"1h30m\"; 0: not by wall time.",
                .unit = "s",
                .range = config::at_least(0.0),
                .duration = true})
          .key("keep", &S::keep, {.about = "How many checkpoints stay.", .range = config::at_least(1.0)})
          .key("at_end", &S::at_end, {.about = "Also write one at the end of the run."});
  return table;
}

}  // namespace bulkley
