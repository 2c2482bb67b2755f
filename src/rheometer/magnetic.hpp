#pragma once
// Yield stress and magnetisation over the strength of the magnetic field.

#include <vector>

#include "material/material.hpp"
#include "rheometer/table.hpp"

namespace bulkley::rheometer {

struct MagneticSettings {
  std::vector<double> fields;     ///< A/m, inside the material, >= 0
  double rate = 0.01;             ///< of the shear that shows the yield stress, 1/s, > 0
  double strain_per_step = 2e-4;  ///< as in SteadySettings
};

/// One row a field strength: `yield_stress` and `magnetisation` of the laws, and the steady shear stress of the kernel at a low
/// rate. Throws UsageError for a material without magnetisation, RunError if the kernel refuses a step. Not collective.
Measurement measure_magnetic(const NamedMaterial& named, const MagneticSettings& settings);

}  // namespace bulkley::rheometer
