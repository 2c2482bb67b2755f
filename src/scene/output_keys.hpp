#pragma once
// Keys of [output] and [checkpoint] of a scene.

#include "bulkley/config/keys.hpp"
#include "scene/output_settings.hpp"

namespace bulkley {

inline config::Names<FloatPrecision> names(config::Of<FloatPrecision>) {
  return {{"float32", FloatPrecision::float32}, {"float64", FloatPrecision::float64}};
}

const config::Keys<Front>& keys(config::Of<Front>);
const config::Keys<Gauge>& keys(config::Of<Gauge>);

inline const config::Keys<OutputSettings>& keys(config::Of<OutputSettings>) {
  using S = OutputSettings;
  static const auto table =
      config::Keys<S>("Output for visualization and analysis.")
          .key("frame_interval", &S::frame_interval,
               {.about = "Simulated time between frames; 0: no frames.", .unit = "s", .range = config::at_least(0.0)})
          .key("history_interval", &S::history_interval,
               {.about = "Steps between rows of history.csv.", .unit = "steps", .range = config::at_least(1.0)})
          .key("separate_energies", &S::separate_energies,
               {.about = "Also tell, with schemes PIC and APIC, the energy lost to the grid from what the time integration "
                         "leaves over, which otherwise are known together only. Particles then differ in the last bits; "
                         "p2g takes longer."})
          .key("progress_interval", &S::progress_interval,
               {.about = "Wall time between progress lines.", .unit = "s", .range = config::at_least(0.0), .duration = true})
          .key("fields", &S::fields,
               {.about = "Fields in frames in addition to the position.", .names = frame_field_names()})
          .key("precision", &S::precision, {.about = "Size of the real numbers in frames."})
          .key("compression", &S::compression,
               {.about =
                    "Deflate level of frames, 1 to 9; 0: none. Level 1 saves a third to a half of the space; only the root "
                    "compresses, about ten times slower than it writes.",
                .range = config::between(0.0, 9.0)})
          .key("grid", &S::grid,
               {.about = "Also write the grid's mass density and velocity; needs a box of tiles for each rank, as "
                         "partition.method \"ranges\" does."})
          .key("tiles", &S::tiles, {.about = "Also write the partition: rank, particles and load of each tile of the grid."})
          .key("magnetic_field", &S::magnetic_field,
               {.about = "Also write the magnetic field on the nodes of its box; needs [magnetics], and solves for it at "
                         "every frame."})
          .key("front", &S::fronts,
               {.about = "Measured reaches of the material, columns of history.csv.", .default_text = "none"})
          .key("gauge", &S::gauges,
               {.about = "Measured forces on patches of walls, columns of history.csv.", .default_text = "none"});
  return table;
}

inline const config::Keys<CheckpointSettings>& keys(config::Of<CheckpointSettings>) {
  using S = CheckpointSettings;
  static const auto table =
      config::Keys<S>("When a run writes a file to restart from; this never changes the result.")
          .key("steps", &S::step_interval,
               {.about = "Steps between checkpoints; 0: not by steps.", .unit = "steps", .range = config::at_least(0.0)})
          .key("wall_time", &S::wall_interval,
               {.about = "Wall time between checkpoints, as a number or like \"10m\" or \"1h30m\"; 0: not by wall time.",
                .unit = "s",
                .range = config::at_least(0.0),
                .duration = true})
          .key("keep", &S::keep, {.about = "Number of checkpoints to keep.", .range = config::at_least(1.0)})
          .key("at_end", &S::at_end, {.about = "Also write one at the end of the run."})
          .key("timeout", &S::timeout,
               {.about =
                    "Wall time after which a checkpoint or frame that is still being written, or a checkpoint that is still "
                    "being read, ends the run with exit code 3, because the file system does not answer; 0: never.",
                .unit = "s",
                .range = config::at_least(0.0),
                .duration = true});
  return table;
}

}  // namespace bulkley
