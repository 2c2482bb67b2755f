#include "rheometer/creep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"
#include "rheometer/analytic.hpp"
#include "rheometer/root.hpp"
#include "rheometer/transient.hpp"

namespace bulkley::rheometer {

namespace {

constexpr double stress_tolerance = 1e-9;  // relative
constexpr double longest_jump = 100.0;     // strain in one step; beyond, the material cannot carry the stress

// A specimen under a held stress.
class Creep {
 public:
  Creep(const Specimen& fresh, double stress) : specimen_(fresh), trial_(fresh), stress_(stress) {}

  double time = 0.0, strain = 0.0, rate = 0.0;
  const Specimen& specimen() const { return specimen_; }

  void step(double dt) {
    const auto excess = [&](double increment) {
      trial_ = specimen_;
      if (!trial_.try_advance(step_gradient(Flow::simple_shear, increment, dt), dt)) return not_a_number;
      return trial_.read().shear_stress - stress_;
    };
    const RootSearch search{.start = rate * dt,
                            .first_step = std::max(1e-9, 0.01 * std::fabs(rate) * dt),
                            .largest = longest_jump,
                            .tolerance = stress_tolerance * stress_};
    const auto increment = find_root(search, excess);
    if (!increment)
      throw RunError(fmt::format("creep: at {:g} s no shear rate gives the stress of {:g} Pa; the material cannot carry it",
                                 time, stress_));
    specimen_ = trial_;
    time += dt;
    strain += *increment;
    rate = *increment / dt;
  }

 private:
  Specimen specimen_, trial_;
  double stress_;
};

void append(const Creep& creep, double stress, Table& table) {
  const Material& material = creep.specimen().material();
  Row row;
  row.add("time", creep.time)
      .add("shear_stress", stress)
      .add("strain", creep.strain)
      .add("shear_rate", creep.rate)
      .add("pressure", creep.specimen().read().pressure);
  if (const auto structure = creep.specimen().structure()) row.add("structure", *structure);
  const double J = creep.specimen().volume_ratio();
  if (const auto maxwell = maxwell_limit(material, J); maxwell && maxwell->viscosity_beside == 0.0)
    row.add("analytic_strain", stress / maxwell->modulus * (1.0 + creep.time / maxwell->relaxation_time));
  if (const auto rate = steady_shear_rate(material, stress, J)) row.add("analytic_steady_rate", *rate);
  row.append_to(table);
}

// Leaves off at the largest strain; true if the whole duration was reached.
bool hold(const CreepSettings& settings, double stress, Creep& creep, Table& table) {
  creep.step(instant * settings.duration);
  creep.rate = 0.0;  // the jump does not predict the rest
  for (const double end : logarithmic_times(settings.duration, settings.n_points)) {
    while (creep.time < end) {
      const double largest = std::min({1e-2 * std::max(creep.time, end / 10.0), settings.duration / settings.n_steps,
                                       settings.strain_per_step / std::fabs(creep.rate)});
      const double left = end - creep.time;
      const double n_steps = std::ceil(left / largest - 1e-9);
      if (n_steps <= 1.0) {
        creep.step(left);
        creep.time = end;
      } else {
        creep.step(left / n_steps);
      }
      if (creep.strain >= settings.largest_strain) {
        append(creep, stress, table);
        return false;
      }
    }
    append(creep, stress, table);
  }
  return true;
}

}  // namespace

Measurement measure_creep(const Material& material, const CreepSettings& settings) {
  Measurement result;
  const Specimen fresh = loaded_specimen(material, settings.pressure);
  for (const double stress : settings.stresses) {
    Creep creep(fresh, stress);
    if (!hold(settings, stress, creep, result.table))
      result.remarks.push_back(fmt::format("at {:g} Pa the specimen was left at a strain of {:g} after {:g} s of {:g} s",
                                           stress, creep.strain, creep.time, settings.duration));
  }
  return result;
}

}  // namespace bulkley::rheometer
