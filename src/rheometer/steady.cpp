#include "rheometer/steady.hpp"

#include <fmt/format.h>

#include <cmath>

#include "rheometer/analytic.hpp"
#include "rheometer/steps.hpp"

namespace bulkley::rheometer {

namespace {

struct SteadyState {
  Reading reading;
  double strain;
  bool steady;
};

double driven_stress(Flow flow, const Reading& reading) {
  return flow == Flow::simple_shear ? reading.shear_stress : reading.first_normal_difference;
}

// One unit of strain after another.
SteadyState march(const SteadySettings& settings, double rate, Specimen& specimen) {
  const int steps_per_unit = count_steps(1.0, settings.strain_per_step);
  const double increment = 1.0 / steps_per_unit;
  SteadyState state{specimen.read(), 0.0, false};
  while (!state.steady && state.strain < settings.largest_strain) {
    const double before = driven_stress(settings.flow, state.reading);
    for (int k = 0; k < steps_per_unit; ++k) specimen.advance(settings.flow, increment, increment / rate);
    state.reading = specimen.read();
    state.strain += 1.0;
    const double now = driven_stress(settings.flow, state.reading);
    state.steady =
        state.strain >= settings.smallest_strain && std::fabs(now - before) <= settings.tolerance * std::fabs(now);
  }
  return state;
}

void add_shear(Row& row, double rate, const Reading& r) {
  row.add("shear_rate", rate)
      .add("shear_stress", r.shear_stress)
      .add("first_normal_stress_difference", r.first_normal_difference)
      .add("second_normal_stress_difference", r.second_normal_difference)
      .add("viscosity", r.shear_stress / rate)
      .add("pressure", r.pressure);
}

void add_extension(Row& row, double rate, const Reading& r) {
  row.add("extension_rate", rate)
      .add("tensile_stress", r.first_normal_difference)
      .add("extensional_viscosity", r.first_normal_difference / rate)
      .add("pressure", r.pressure);
}

}  // namespace

Measurement measure_steady(const Material& material, const SteadySettings& settings) {
  Measurement result;
  const Specimen fresh = loaded_specimen(material, settings.pressure);
  std::size_t n_unsteady = 0;
  for (const double rate : settings.rates) {
    Specimen specimen(fresh);
    const SteadyState state = march(settings, rate, specimen);
    Row row;
    if (settings.flow == Flow::simple_shear)
      add_shear(row, rate, state.reading);
    else
      add_extension(row, rate, state.reading);
    if (const auto structure = specimen.structure()) row.add("structure", *structure);
    row.add("strain", state.strain).add("steady", state.steady ? 1.0 : 0.0);
    if (const auto truth = steady_flow(material, settings.flow, rate, specimen.volume_ratio()))
      row.add("analytic_stress", truth->stress).add("small_strain_stress", truth->small_strain_stress);
    row.append_to(result.table);
    n_unsteady += state.steady ? 0 : 1;
  }
  if (n_unsteady > 0)
    result.remarks.push_back(fmt::format("{} of {} rates are not steady after a strain of {:g} (column steady is 0){}",
                                         n_unsteady, settings.rates.size(), settings.largest_strain,
                                         flows(material) ? "" : "; this material is a solid, --mode startup suits it"));
  return result;
}

}  // namespace bulkley::rheometer
