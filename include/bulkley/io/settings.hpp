#pragma once
// What a run writes, tables [output] and [checkpoint] of a scene.

#include <string>
#include <vector>

namespace bulkley {

enum class FloatPrecision { float32, float64 };

struct OutputSettings {
  double frame_interval = 0.0;     ///< s; 0: no frames
  int history_interval = 10;       ///< steps between rows of history.csv
  double progress_interval = 2.0;  ///< s of wall time between progress lines
  std::vector<std::string> fields{"velocity", "material",          "volume_ratio",
                                  "pressure", "deviatoric_stress", "plastic_shear_rate"};
  FloatPrecision precision = FloatPrecision::float32;
  bool grid = false;  ///< also write grid mass density and velocity
};

struct CheckpointSettings {
  long step_interval = 0;      ///< steps; 0: not by steps
  double wall_interval = 0.0;  ///< s of wall time; 0: not by wall time
  int keep = 2;                ///< whole checkpoints kept; at least 1
  bool at_end = true;          ///< also at the end of the run
};

}  // namespace bulkley
