#include "rheometer/fit.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bulkley/base/error.hpp"
#include "rheometer/root.hpp"

namespace bulkley::rheometer {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// The weighted problem. Rates are in units of their geometric mean: then rate^n stays near 1.
struct Problem {
  std::vector<double> log_rate, stress, weight;
  double log_unit;
  const FitSettings& settings;

  std::size_t size() const { return stress.size(); }
  double power(std::size_t k, double n) const { return std::exp(n * (log_rate[k] - log_unit)); }
  double unit_power(double n) const { return std::exp(n * log_unit); }  // unit^n
};

struct Candidate {
  double yield_stress, scaled_consistency, flow_index;  // Pa, Pa (K unit^n), 1
  double squares = infinity;
};

double squares_of(const Problem& problem, const Candidate& c) {
  double sum = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double fitted = c.yield_stress + c.scaled_consistency * problem.power(k, c.flow_index);
    const double residual = problem.weight[k] * (fitted - problem.stress[k]);
    sum += residual * residual;
  }
  return sum;
}

// Best yield stress for this consistency, or the reverse: projection of what one function (1 or rate^n) leaves on the other.
double project(const Problem& problem, double n, bool on_power, double other) {
  double numerator = 0.0, denominator = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double power = problem.power(k, n);
    const double basis = problem.weight[k] * (on_power ? power : 1.0);
    const double left = problem.weight[k] * (problem.stress[k] - other * (on_power ? 1.0 : power));
    numerator += basis * left;
    denominator += basis * basis;
  }
  return std::max(0.0, numerator / denominator);
}

// Both free and unbounded: rate^n less its weighted mean is orthogonal to 1.
Candidate unbounded(const Problem& problem, double n) {
  double weights = 0.0, mean = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double w = problem.weight[k] * problem.weight[k];
    weights += w;
    mean += w * problem.power(k, n);
  }
  mean /= weights;
  double numerator = 0.0, denominator = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double w = problem.weight[k] * problem.weight[k], deviation = problem.power(k, n) - mean;
    numerator += w * deviation * problem.stress[k];
    denominator += w * deviation * deviation;
  }
  const double K = numerator / denominator;
  double left = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k)
    left += problem.weight[k] * problem.weight[k] * (problem.stress[k] - K * problem.power(k, n));
  return {left / weights, K, n};
}

// The bounded linear problem at a given index. Its minimum is the unbounded one, or lies on an edge.
Candidate best_at(const Problem& problem, double n) {
  const FitSettings& given = problem.settings;
  std::vector<Candidate> candidates;
  if (given.yield_stress && given.consistency) {
    candidates = {{*given.yield_stress, *given.consistency * problem.unit_power(n), n}};
  } else if (given.yield_stress) {
    candidates = {{*given.yield_stress, project(problem, n, true, *given.yield_stress), n}};
  } else if (given.consistency) {
    const double scaled = *given.consistency * problem.unit_power(n);
    candidates = {{project(problem, n, false, scaled), scaled, n}};
  } else {
    candidates = {{0.0, project(problem, n, true, 0.0), n}, {project(problem, n, false, 0.0), 0.0, n}};
    const Candidate inner = unbounded(problem, n);
    if (inner.yield_stress >= 0.0 && inner.scaled_consistency >= 0.0) candidates.push_back(inner);
  }
  for (Candidate& each : candidates) each.squares = squares_of(problem, each);
  return *std::min_element(candidates.begin(), candidates.end(),
                           [](const Candidate& a, const Candidate& b) { return a.squares < b.squares; });
}

Candidate golden_section(const Problem& problem, double lower, double upper) {
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  Candidate left = best_at(problem, upper - ratio * (upper - lower));
  Candidate right = best_at(problem, lower + ratio * (upper - lower));
  while (upper - lower > 1e-12 && left.flow_index < right.flow_index) {
    if (left.squares <= right.squares) {
      upper = right.flow_index;
      right = left;
      left = best_at(problem, upper - ratio * (upper - lower));
    } else {
      lower = left.flow_index;
      left = right;
      right = best_at(problem, lower + ratio * (upper - lower));
    }
  }
  return left.squares <= right.squares ? left : right;
}

Candidate best(const Problem& problem) {
  if (problem.settings.flow_index) return best_at(problem, *problem.settings.flow_index);
  constexpr int n_scan = 290;
  const double spacing = (largest_flow_index - smallest_flow_index) / n_scan;
  Candidate found{};
  for (int k = 0; k <= n_scan; ++k) {
    const Candidate here = best_at(problem, k == n_scan ? largest_flow_index : smallest_flow_index + k * spacing);
    if (here.squares < found.squares) found = here;
  }
  const double lower = std::max(smallest_flow_index, found.flow_index - spacing);
  const double upper = std::min(largest_flow_index, found.flow_index + spacing);
  const Candidate refined = golden_section(problem, lower, upper);
  return refined.squares < found.squares ? refined : found;
}

Problem make_problem(const MeasuredCurve& curve, const FitSettings& settings, Fit& fit) {
  if (settings.weights == Weights::error && curve.error.empty())
    throw UsageError("--weights error: the file has no column 'error'");
  Problem problem{{}, {}, {}, 0.0, settings};
  for (std::size_t k = 0; k < curve.stress.size(); ++k) {
    const double rate = curve.shear_rate[k], stress = curve.stress[k];
    if (settings.rates && (rate < settings.rates->lower || rate > settings.rates->upper)) continue;
    problem.log_rate.push_back(std::log(rate));
    problem.stress.push_back(stress);
    problem.weight.push_back(settings.weights == Weights::relative  ? 1.0 / stress
                             : settings.weights == Weights::uniform ? 1.0
                                                                    : 1.0 / curve.error[k]);
    fit.points.push_back({rate, stress, not_a_number});
  }
  fit.n_left_out = curve.stress.size() - fit.points.size();
  if (problem.size() < fewest_points)
    throw UsageError(fmt::format("{} points{} are too few to fit; at least {} are needed", problem.size(),
                                 settings.rates ? " within --range" : "", fewest_points));
  for (const double each : problem.log_rate) problem.log_unit += each / static_cast<double>(problem.size());
  const auto [lowest, highest] = std::minmax_element(problem.log_rate.begin(), problem.log_rate.end());
  if (*highest == *lowest) throw UsageError("all points have the same shear rate; a flow curve needs several");
  return problem;
}

Estimate estimate_of(const std::optional<double>& given, double value, double lower, double upper) {
  constexpr double closeness = 1e-9;
  if (given) return Estimate::fixed;
  if (value <= lower + closeness * std::fabs(lower)) return Estimate::at_lower_bound;
  if (value >= upper - closeness * std::fabs(upper)) return Estimate::at_upper_bound;
  return Estimate::fitted;
}

// Of tau_y, K and n, zero where not fitted; NaN where the points do not determine the parameters.
Eigen::Matrix3d covariance(const Problem& problem, const Fit& fit, double variance) {
  const double n = fit.flow_index.value, K = fit.consistency.value;
  const bool free[3] = {fit.yield_stress.estimate == Estimate::fitted, fit.consistency.estimate == Estimate::fitted,
                        fit.flow_index.estimate == Estimate::fitted && K > 0.0};
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double power = std::exp(n * problem.log_rate[k]);
    Eigen::Vector3d slope(1.0, power, K * power * problem.log_rate[k]);
    for (int a = 0; a < 3; ++a) slope[a] *= free[a] ? problem.weight[k] : 0.0;
    normal += slope * slope.transpose();
  }
  // The diagonal made 1, so that units do not degrade the inverse.
  Eigen::Vector3d scale;
  for (int a = 0; a < 3; ++a) {
    if (!free[a]) normal(a, a) = 1.0;
    scale[a] = 1.0 / std::sqrt(normal(a, a));
  }
  const Eigen::Matrix3d scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  constexpr double smallest_determinant = 1e-14;  // 1 if the parameters were independent
  Eigen::Matrix3d result;
  bool invertible = false;
  scaled.computeInverseWithCheck(result, invertible, smallest_determinant);
  if (!invertible) return Eigen::Matrix3d::Constant(not_a_number);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) result(a, b) *= free[a] && free[b] ? variance * scale[a] * scale[b] : 0.0;
  return result;
}

void set_standard_errors(const Eigen::Matrix3d& cov, Fit& fit) {
  Parameter* all[3] = {&fit.yield_stress, &fit.consistency, &fit.flow_index};
  for (int a = 0; a < 3; ++a)
    all[a]->standard_error = all[a]->estimate == Estimate::fitted ? std::sqrt(cov(a, a)) : not_a_number;
  if (fit.consistency.value == 0.0) fit.flow_index.standard_error = not_a_number;  // it plays no part
}

// (T24), and its derivatives for the errors: eta depends on K and on n.
void set_yue(const Eigen::Matrix3d& cov, Fit& fit) {
  HerschelBulkley::Parameters yue;
  set_flow(yue, {fit.yield_stress.value, fit.consistency.value, fit.flow_index.value});
  fit.sigma_Y = {yue.sigma_Y, std::sqrt(3.0) * fit.yield_stress.standard_error, fit.yield_stress.estimate};
  fit.h = fit.flow_index;
  const double per_K = std::pow(2.0, 0.5 * (1.0 + yue.h)), per_n = 0.5 * std::log(2.0) * yue.eta;
  const double variance = per_K * per_K * cov(1, 1) + 2.0 * per_K * per_n * cov(1, 2) + per_n * per_n * cov(2, 2);
  const bool moves = fit.consistency.estimate == Estimate::fitted || fit.flow_index.estimate == Estimate::fitted;
  const Estimate estimate = fit.consistency.estimate == Estimate::at_lower_bound ? Estimate::at_lower_bound
                            : moves                                              ? Estimate::fitted
                                                                                 : fit.consistency.estimate;
  fit.eta = {yue.eta, estimate == Estimate::fitted ? std::sqrt(variance) : not_a_number, estimate};
}

void set_quality(const Problem& problem, double squares, std::size_t n_free, Fit& fit) {
  double mean = 0.0, weights = 0.0, about_mean = 0.0, relative = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double w = problem.weight[k] * problem.weight[k];
    mean += w * problem.stress[k];
    weights += w;
  }
  mean /= weights;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double deviation = problem.weight[k] * (problem.stress[k] - mean);
    about_mean += deviation * deviation;
    relative += fit.points[k].relative_residual() * fit.points[k].relative_residual();
  }
  const auto n = static_cast<double>(problem.size());
  fit.relative_rms = std::sqrt(relative / n);
  fit.r_squared = 1.0 - squares / about_mean;
  fit.reduced_chi_square = squares / std::max(1.0, n - static_cast<double>(n_free));
}

// How many standard deviations the number of runs of residuals of one sign, by ascending rate, lies below that of
// independent residuals (Wald and Wolfowitz 1940).
double systematic(const Fit& fit) {
  std::vector<FitPoint> points = fit.points;
  std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.shear_rate < b.shear_rate; });
  double n_above = 0.0, n_runs = 1.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const bool above = points[k].relative_residual() > 0.0;
    n_above += above ? 1.0 : 0.0;
    if (k > 0 && above != (points[k - 1].relative_residual() > 0.0)) n_runs += 1.0;
  }
  const auto n = static_cast<double>(points.size());
  const double product = 2.0 * n_above * (n - n_above);
  const double expected = product / n + 1.0, variance = product * (product - n) / (n * n * (n - 1.0));
  return variance > 0.0 ? (expected - n_runs) / std::sqrt(variance) : 0.0;
}

void add_warnings(const FitSettings& settings, Fit& fit) {
  constexpr double poor_rms = 0.05, poor_r_squared = 0.98, poor_chi_square = 3.0;
  constexpr double too_systematic = 2.5, exact = 1e-3;  // standard deviations; relative rms of data without noise
  if (fit.relative_rms > poor_rms)
    fit.warnings.push_back(fmt::format(
        "poor fit: the stresses differ by {:.1f} % (rms) from the curve; check the residuals, and fit a narrower "
        "--range if the material is not a Herschel-Bulkley fluid over all of it",
        100.0 * fit.relative_rms));
  if (!(fit.r_squared > poor_r_squared))
    fit.warnings.push_back(fmt::format("poor fit: R^2 is {:.3f}; the rate explains little of the stress", fit.r_squared));
  if (settings.weights == Weights::error && fit.reduced_chi_square > poor_chi_square)
    fit.warnings.push_back(fmt::format(
        "the residuals are {:.1f} times as large as the errors in the file; the standard errors below are too small",
        std::sqrt(fit.reduced_chi_square)));
  if (fit.relative_rms > exact && systematic(fit) > too_systematic)
    fit.warnings.push_back(
        "the residuals are not scatter but follow the rate in long runs of one sign: the law does not quite have this "
        "curve's "
        "shape, the parameters depend on the range that is fitted, and the standard errors are too small");
  const auto unresolved = [&](const char* name, const Parameter& p) {
    if (p.estimate == Estimate::fitted && !(p.value > 2.0 * p.standard_error))
      fit.warnings.push_back(
          fmt::format("{} is not resolved by these points: its standard error is {:.2g}", name, p.standard_error));
  };
  unresolved("yield_stress", fit.yield_stress);
  unresolved("consistency", fit.consistency);
  if (fit.flow_index.estimate == Estimate::at_lower_bound || fit.flow_index.estimate == Estimate::at_upper_bound)
    fit.warnings.push_back(
        fmt::format("flow_index is at its bound of {:g}: another law may suit the material better", fit.flow_index.value));
  if (fit.consistency.value == 0.0) fit.warnings.push_back("consistency is 0: the stress does not rise with the rate");
}

}  // namespace

Fit fit_herschel_bulkley(const MeasuredCurve& curve, const FitSettings& settings) {
  Fit fit{};
  const Problem problem = make_problem(curve, settings, fit);
  const Candidate found = best(problem);
  const double n = found.flow_index, K = found.scaled_consistency / problem.unit_power(n);
  fit.yield_stress = {found.yield_stress, not_a_number,
                      estimate_of(settings.yield_stress, found.yield_stress, 0.0, infinity)};
  fit.consistency = {K, not_a_number, estimate_of(settings.consistency, K, 0.0, infinity)};
  fit.flow_index = {n, not_a_number, estimate_of(settings.flow_index, n, smallest_flow_index, largest_flow_index)};
  for (std::size_t k = 0; k < problem.size(); ++k)
    fit.points[k].fitted = found.yield_stress + found.scaled_consistency * problem.power(k, n);

  std::size_t n_free = 0;
  for (const Parameter* p : {&fit.yield_stress, &fit.consistency, &fit.flow_index})
    n_free += p->estimate == Estimate::fitted ? 1 : 0;
  set_quality(problem, found.squares, n_free, fit);
  const Eigen::Matrix3d cov = covariance(problem, fit, settings.weights == Weights::error ? 1.0 : fit.reduced_chi_square);
  set_standard_errors(cov, fit);
  set_yue(cov, fit);
  add_warnings(settings, fit);
  return fit;
}

}  // namespace bulkley::rheometer
