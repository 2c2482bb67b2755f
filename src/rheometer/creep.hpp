#pragma once
// Creep: the strain over time under a shear stress that is held.

#include <vector>

#include "rheometer/specimen.hpp"
#include "rheometer/table.hpp"

namespace bulkley::rheometer {

struct CreepSettings {
  std::vector<double> stresses;   ///< Pa, > 0
  double duration = 10.0;         ///< s
  double largest_strain = 20.0;   ///< where a specimen that flows is left
  double strain_per_step = 2e-4;  ///< at most, after the elastic jump at the start
  int n_steps = 2000;             ///< at least, of the later part; early steps are a hundredth of the time
  int n_points = 200;             ///< rows a stress, evenly over the logarithm of time
  double pressure = 0.0;          ///< Pa, see loaded_specimen
};

/// Strain and shear rate under each stress, from fresh specimens; the rate of every step is the one at whose end the stress
/// is the wanted one. Throws RunError if no rate carries the stress. Columns: docs/rheometer.md. Not collective.
Measurement measure_creep(const Material& material, const CreepSettings& settings);

}  // namespace bulkley::rheometer
