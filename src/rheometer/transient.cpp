#include "rheometer/transient.hpp"

#include <algorithm>
#include <cmath>

#include "rheometer/analytic.hpp"
#include "rheometer/steps.hpp"

namespace bulkley::rheometer {

namespace {

std::optional<double> analytic_start_up(const Specimen& specimen, Flow flow, double rate, double strain) {
  const double J = specimen.volume_ratio();
  if (const auto solid = solid_stress(specimen.material(), flow, strain, J)) return solid->stress;
  if (flow != Flow::simple_shear) return std::nullopt;
  const auto maxwell = maxwell_limit(specimen.material(), J);
  if (!maxwell) return std::nullopt;
  const double time = maxwell->relaxation_time;
  return rate *
         (maxwell->modulus * time * -std::expm1(-strain / (rate * time)) + (strain > 0.0 ? maxwell->viscosity_beside : 0.0));
}

void append_start_up(const Specimen& specimen, const StartUpSettings& settings, double rate, double strain, Table& table) {
  const Reading r = specimen.read();
  Row row;
  row.add("time", strain / rate);
  if (settings.flow == Flow::simple_shear)
    row.add("shear_rate", rate)
        .add("strain", strain)
        .add("shear_stress", r.shear_stress)
        .add("first_normal_stress_difference", r.first_normal_difference)
        .add("second_normal_stress_difference", r.second_normal_difference);
  else
    row.add("extension_rate", rate).add("strain", strain).add("tensile_stress", r.first_normal_difference);
  row.add("pressure", r.pressure);
  if (const auto structure = specimen.structure()) row.add("structure", *structure);
  if (const auto truth = analytic_start_up(specimen, settings.flow, rate, strain)) row.add("analytic_stress", *truth);
  row.append_to(table);
}

// Interval `k` of the three.
void append_interval(const ThixotropySettings& settings, int k, double begin, double& strain, Specimen& specimen,
                     Table& table) {
  const double rate = settings.rates[k], duration = settings.durations[k];
  const int n_wanted = std::max(settings.n_steps, count_steps(rate * duration, settings.strain_per_step));
  const int per_point = (n_wanted + settings.n_points - 1) / settings.n_points;
  const int n_steps = per_point * settings.n_points;
  const double dt = duration / n_steps;
  const auto steady =
      rate > 0.0 ? steady_flow(specimen.material(), Flow::simple_shear, rate, specimen.volume_ratio()) : std::nullopt;
  const bool has_theory = steady_flow(specimen.material(), Flow::simple_shear, 1.0).has_value();
  for (int step = 1; step <= n_steps; ++step) {
    specimen.advance(Flow::simple_shear, rate * dt, dt);
    if (step % per_point != 0) continue;
    const Reading r = specimen.read();
    Row row;
    row.add("time", begin + step * dt)
        .add("interval", k + 1)
        .add("shear_rate", rate)
        .add("strain", strain + rate * step * dt)
        .add("shear_stress", r.shear_stress)
        .add("first_normal_stress_difference", r.first_normal_difference)
        .add("pressure", r.pressure);
    if (const auto structure = specimen.structure()) row.add("structure", *structure);
    if (has_theory) row.add("analytic_steady_stress", steady ? steady->stress : std::nan(""));
    row.append_to(table);
  }
  strain += rate * duration;
}

}  // namespace

std::vector<double> logarithmic_times(double duration, int n) {
  constexpr double span = 1e5;
  std::vector<double> times;
  for (int k = 0; k < n; ++k) times.push_back(n == 1 ? duration : duration * std::pow(span, (k + 1.0 - n) / (n - 1.0)));
  return times;
}

Measurement measure_start_up(const Material& material, const StartUpSettings& settings) {
  Measurement result;
  const Specimen fresh = loaded_specimen(material, settings.pressure);
  const int per_point = count_steps(settings.strain / settings.n_points, settings.strain_per_step);
  const int n_steps = per_point * settings.n_points;
  const double increment = settings.strain / n_steps;
  for (const double rate : settings.rates) {
    Specimen specimen(fresh);
    append_start_up(specimen, settings, rate, 0.0, result.table);
    for (int step = 1; step <= n_steps; ++step) {
      specimen.advance(settings.flow, increment, increment / rate);
      if (step % per_point == 0) append_start_up(specimen, settings, rate, step * increment, result.table);
    }
  }
  return result;
}

Measurement measure_relaxation(const Material& material, const RelaxationSettings& settings) {
  Measurement result;
  Specimen specimen = loaded_specimen(material, settings.pressure);
  specimen.advance(Flow::simple_shear, settings.strain, instant * settings.duration);
  const auto maxwell = maxwell_limit(material, specimen.volume_ratio());
  double time = 0.0;
  for (const double end : logarithmic_times(settings.duration, settings.n_points)) {
    const double largest = std::min(1e-3 * std::max(time, end / 10.0), settings.duration / settings.n_steps);
    const int n_steps = count_steps(end - time, largest);
    for (int k = 0; k < n_steps; ++k) specimen.advance(Flow::simple_shear, 0.0, (end - time) / n_steps);
    time = end;
    const Reading r = specimen.read();
    Row row;
    row.add("time", time)
        .add("strain", settings.strain)
        .add("shear_stress", r.shear_stress)
        .add("relaxation_modulus", r.shear_stress / settings.strain)
        .add("first_normal_stress_difference", r.first_normal_difference)
        .add("pressure", r.pressure);
    if (const auto structure = specimen.structure()) row.add("structure", *structure);
    if (maxwell) row.add("analytic_stress", maxwell->modulus * settings.strain * std::exp(-time / maxwell->relaxation_time));
    row.append_to(result.table);
  }
  return result;
}

Measurement measure_thixotropy(const Material& material, const ThixotropySettings& settings) {
  Measurement result;
  Specimen specimen = loaded_specimen(material, settings.pressure);
  double begin = 0.0, strain = 0.0;
  for (int k = 0; k < 3; ++k) {
    append_interval(settings, k, begin, strain, specimen, result.table);
    begin += settings.durations[k];
  }
  return result;
}

}  // namespace bulkley::rheometer
