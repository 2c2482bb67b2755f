#pragma once
// What a run writes, tables [output] and [checkpoint] of a scene.

#include <string>
#include <vector>

#include "bulkley/particle/particle_set.hpp"
#include "grid/gauge.hpp"

namespace bulkley {

enum class FloatPrecision { float32, float64 };

/// Names that `output.fields` may hold: the fields of checkpoints but the position, which is always written, and the derived
/// ones (derived_fields). Symmetric tensors are written with all nine components. Not collective.
std::vector<std::string> frame_field_names();

/// The fields among them that `particles` have of their own. Not collective.
std::vector<std::string> particle_field_names(const ParticleSet& particles);

/// A measured reach of the material, table [[output.front]]: along a direction, or as the distance from an axis.
struct Front {
  std::string name;
  std::optional<Vec3> direction;        ///< any length > 0
  std::optional<Vec3> axis;             ///< of the axis, any length > 0
  Vec3 origin = Vec3::Zero();           ///< m, where the reach is 0
  std::optional<std::string> material;  ///< only particles of that one
  double quantile = 1.0;                ///< part of the mass that the reach comprises
  std::optional<Vec3> eye;              ///< m; the front is that of the shadow that a lamp there throws
  double plane = 0.0;                   ///< m, height z of the floor under the shadow; with `eye`
  int material_number = -1;             ///< of `material` in the scene; -1: all
};

struct OutputSettings {
  double frame_interval = 0.0;     ///< s; 0: no frames
  int history_interval = 10;       ///< steps between rows of history.csv
  double progress_interval = 2.0;  ///< s of wall time between progress lines
  std::vector<std::string> fields{"velocity", "material",          "volume_ratio",
                                  "pressure", "deviatoric_stress", "plastic_shear_rate"};
  FloatPrecision precision = FloatPrecision::float32;
  int compression = 0;  ///< deflate level of frames, 1 to 9; 0: none
  bool grid = false;    ///< also write grid mass density and velocity
  bool separate_energies = false;  ///< history.csv tells the transfer to the grid from the time integration with every transfer
  bool tiles = false;   ///< also write rank, particles and load of each tile
  bool magnetic_field = false;  ///< also write the magnetic field on the nodes of its box
  std::vector<Front> fronts;
  std::vector<Gauge> gauges;
};

struct CheckpointSettings {
  long step_interval = 0;      ///< steps; 0: not by steps
  double wall_interval = 0.0;  ///< s of wall time; 0: not by wall time
  int keep = 2;                ///< whole checkpoints kept; at least 1
  bool at_end = true;          ///< also at the end of the run
  double timeout = 600.0;      ///< s; a checkpoint or frame that takes longer to write ends the run; 0: never
};

}  // namespace bulkley
