#pragma once
// Oscillatory shear: storage and loss modulus from the last cycle.

#include <vector>

#include "rheometer/specimen.hpp"
#include "rheometer/table.hpp"

namespace bulkley::rheometer {

struct OscillationSettings {
  std::vector<double> amplitudes;   ///< of the strain, > 0
  std::vector<double> frequencies;  ///< angular, rad/s, > 0
  double strain_per_step = 2e-4;    ///< at most
  int steps_per_cycle = 4000;       ///< at least
  int smallest_cycles = 3;
  int largest_cycles = 500;  ///< read off there even if the moduli still change
  double tolerance = 1e-5;   ///< change of G' + i G'' from cycle to cycle, relative to its size, that counts as none
  double pressure = 0.0;     ///< Pa, see loaded_specimen
};

/// One row for each amplitude and frequency, under the strain amplitude * sin(frequency * time) from rest, extrapolated
/// from two numbers of steps. Throws RunError if the kernel refuses a step. Columns: docs/rheometer.md. Not collective.
Measurement measure_oscillation(const Material& material, const OscillationSettings& settings);

}  // namespace bulkley::rheometer
