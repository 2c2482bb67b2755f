#pragma once
// A measured flow curve, as a rheometer's export gives it.

#include <string>
#include <vector>

namespace bulkley::rheometer {

struct MeasuredCurve {
  std::vector<double> shear_rate;  ///< 1/s, > 0
  std::vector<double> stress;      ///< Pa, > 0
  std::vector<double> error;       ///< standard deviation of the stress, Pa, > 0; empty if the file has none
};

/// Reads comma-separated text: a header that names the columns shear_rate, stress and, if there, error, in any order among
/// others; one line a point; empty lines and lines that begin with '#' are skipped. `name` is the file's, for messages.
/// Throws UsageError with one sentence, "file:line: ...". Not collective.
MeasuredCurve parse_measured_curve(const std::string& text, const std::string& name);

}  // namespace bulkley::rheometer
