#include "rheometer/fit_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace bulkley::rheometer {

namespace {

std::string error_text(const Parameter& p) {
  switch (p.estimate) {
    case Estimate::fixed:
      return "given";
    case Estimate::at_lower_bound:
      return "at its lower bound";
    case Estimate::at_upper_bound:
      return "at its upper bound";
    case Estimate::fitted:
      break;
  }
  return std::isfinite(p.standard_error) ? fmt::format("+- {:.2g}", p.standard_error) : "not determined by these points";
}

std::string line(const char* name, const Parameter& p, const char* unit) {
  return fmt::format("  {:<13}= {:<10.5g} {:<7} {}\n", name, p.value, unit, error_text(p));
}

const char* name_of(Weights weights) {
  switch (weights) {
    case Weights::relative:
      return "relative";
    case Weights::uniform:
      return "uniform";
    case Weights::error:
      return "error";
  }
  return "";
}

double largest(const Fit& fit, double FitPoint::*member) {
  double value = 0.0;
  for (const FitPoint& point : fit.points) value = std::max(value, point.*member);
  return value;
}

double smallest_rate(const Fit& fit) {
  double value = fit.points.front().shear_rate;
  for (const FitPoint& point : fit.points) value = std::min(value, point.shear_rate);
  return value;
}

// Rounded up to two digits: a suggestion is not a measurement.
double rounded_up(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::ceil(value / unit - 1e-9) * unit;
}

}  // namespace

std::string fit_text(const Fit& fit, const FitSettings& settings) {
  std::string text = fmt::format(
      "Herschel-Bulkley fit to {} points, shear rates {:g} to {:g} 1/s ({} points left out), weights: {}\n\n",
      fit.points.size(), smallest_rate(fit), largest(fit, &FitPoint::shear_rate), fit.n_left_out, name_of(settings.weights));
  text += "shear rheometer, stress = yield_stress + consistency * shear_rate^flow_index (value and standard error)\n";
  text += line("yield_stress", fit.yield_stress, "Pa") + line("consistency", fit.consistency, "Pa s^n") +
          line("flow_index", fit.flow_index, "");
  text += "Yue et al. (2015)\n";
  text += line("sigma_Y", fit.sigma_Y, "Pa") + line("eta", fit.eta, "Pa s^h") + line("h", fit.h, "");
  text += fmt::format("\nrms relative residual {:.4g}, R^2 {:.6g} (weighted)", fit.relative_rms, fit.r_squared);
  if (settings.weights == Weights::error) text += fmt::format(", reduced chi^2 {:.4g}", fit.reduced_chi_square);
  text += fmt::format("\n\n{:>16} {:>13} {:>13} {:>13}\n", "shear_rate [1/s]", "stress [Pa]", "fitted [Pa]", "residual [%]");
  for (const FitPoint& p : fit.points)
    text += fmt::format("{:>16.6g} {:>13.6g} {:>13.6g} {:>13.2f}\n", p.shear_rate, p.stress, p.fitted,
                        100.0 * p.relative_residual());
  for (const std::string& warning : fit.warnings) text += fmt::format("\nwarning: {}", warning);
  if (!fit.warnings.empty()) text += "\n";
  return text;
}

std::string scene_snippet(const Fit& fit, const Suggestions& s) {
  const double largest_stress = std::max(largest(fit, &FitPoint::stress), largest(fit, &FitPoint::fitted));
  constexpr double stiffness = 20.0;
  std::string text = fmt::format("[materials.{}]\n", s.name);
  text += "law = \"herschel_bulkley\"\n";
  text += fmt::format("density = {:.6g}          # kg/m^3; SUGGESTION: put the measured one\n", s.density);
  text += fmt::format("bulk_modulus = {:.6g}     # Pa; SUGGESTION: >= density * (10 v)^2 for speeds v up to {:g} m/s\n",
                      rounded_up(100.0 * s.density * s.speed * s.speed), s.speed);
  text += fmt::format(
      "shear_modulus = {:.6g}    # Pa; SUGGESTION: 10 to 50 x the largest stress ({:.4g} Pa); better the measured slope\n"
      "                         # of stress over strain below yield\n",
      rounded_up(stiffness * largest_stress), largest_stress);
  text += fmt::format(
      "# fitted to shear rates {:g} to {:g} 1/s; the same in Yue's convention: sigma_Y = {:.6g}, eta = {:.6g}, h = {:.6g}\n",
      smallest_rate(fit), largest(fit, &FitPoint::shear_rate), fit.sigma_Y.value, fit.eta.value, fit.h.value);
  text += fmt::format("yield_stress = {:.6g}     # Pa\n", fit.yield_stress.value);
  text += fmt::format("consistency = {:.6g}      # Pa s^n\n", fit.consistency.value);
  text += fmt::format("flow_index = {:.6g}\n", fit.flow_index.value);
  return text;
}

Table fit_table(const Fit& fit) {
  Table table;
  for (const FitPoint& p : fit.points)
    Row()
        .add("shear_rate", p.shear_rate)
        .add("stress", p.stress)
        .add("fitted_stress", p.fitted)
        .add("relative_residual", p.relative_residual())
        .append_to(table);
  return table;
}

std::string material_name(const std::string& path) {
  std::string name = path.substr(path.find_last_of('/') + 1);
  name = name.substr(0, name.find('.'));
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') c = '_';
  return name.empty() ? "fluid" : name;
}

}  // namespace bulkley::rheometer
