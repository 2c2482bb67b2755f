#pragma once
// Steady flow over a range of rates: the flow curve, and its like in extension.

#include <vector>

#include "rheometer/specimen.hpp"
#include "rheometer/table.hpp"

namespace bulkley::rheometer {

struct SteadySettings {
  Flow flow = Flow::simple_shear;
  std::vector<double> rates;      ///< 1/s, > 0
  double strain_per_step = 2e-4;  ///< strain of one step of the kernel
  double smallest_strain = 6.0;   ///< never read off before
  double largest_strain = 100.0;  ///< read off there even if the stress still changes
  double tolerance = 1e-5;        ///< relative change over the last unit of strain that counts as steady
  double pressure = 0.0;          ///< Pa, see loaded_specimen
};

/// One row a rate, each from a fresh specimen. Columns: docs/rheometer.md. A remark lists the rates at which the stress is
/// not steady. Throws RunError if the kernel refuses a step. Not collective.
Measurement measure_steady(const Material& material, const SteadySettings& settings);

}  // namespace bulkley::rheometer
