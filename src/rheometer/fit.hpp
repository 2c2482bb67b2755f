#pragma once
// Herschel-Bulkley parameters from a measured flow curve, by weighted least squares within bounds.

#include <optional>
#include <string>
#include <vector>

#include "material/laws/herschel_bulkley.hpp"
#include "rheometer/measured_curve.hpp"
#include "rheometer/number_list.hpp"

namespace bulkley::rheometer {

/// What a residual is divided by.
enum class Weights {
  relative,  ///< the measured stress: every decade has equal weight
  uniform,   ///< nothing: the largest stresses count most
  error,     ///< the standard deviation that was measured
};

struct FitSettings {
  Weights weights = Weights::relative;
  std::optional<Range> rates = std::nullopt;  ///< 1/s; points outside are left out
  /// Values that are given instead of fitted.
  std::optional<double> yield_stress = std::nullopt, consistency = std::nullopt, flow_index = std::nullopt;
};

/// How a parameter came to its value.
enum class Estimate { fitted, fixed, at_lower_bound, at_upper_bound };

struct Parameter {
  double value;
  double standard_error;  ///< NaN unless fitted
  Estimate estimate;
};

struct FitPoint {
  double shear_rate, stress, fitted;  ///< 1/s, Pa, Pa
  double relative_residual() const { return (fitted - stress) / stress; }
};

struct Fit {
  Parameter yield_stress, consistency, flow_index;  ///< rheometer's convention: Pa, Pa s^n, 1
  Parameter sigma_Y, eta, h;                        ///< Yue's: Pa, Pa s^h, 1
  std::vector<FitPoint> points;                     ///< those fitted, in the file's order
  std::size_t n_left_out;
  double relative_rms;        ///< of the relative residuals
  double r_squared;           ///< 1 - (squares of the residuals) / (squares about the mean), weighted like the fit
  double reduced_chi_square;  ///< weighted squares of the residuals over degrees of freedom
  std::vector<std::string> warnings;
};

inline constexpr double smallest_flow_index = 0.1, largest_flow_index = 3.0;  ///< what the law takes
inline constexpr std::size_t fewest_points = 4;                               ///< more than parameters

/// Minimises sum ((yield_stress + consistency rate^flow_index - stress) / weight)^2 over yield_stress >= 0, consistency >= 0
/// and flow_index in its bounds. For a given index the problem is linear, and solved exactly; the index is scanned over its
/// whole range and refined by the golden section, so no start value is needed and a second minimum is not taken for the
/// best. Standard errors are those of the linearised problem, of the parameters that are neither fixed nor at a bound; with
/// relative and uniform weights the scatter is estimated from the residuals. Throws UsageError if there are too few points,
/// or no error column for Weights::error. Not collective.
Fit fit_herschel_bulkley(const MeasuredCurve& curve, const FitSettings& settings);

}  // namespace bulkley::rheometer
