#include "rheometer/oscillation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "rheometer/analytic.hpp"
#include "rheometer/steps.hpp"

namespace bulkley::rheometer {

namespace {

using Complex = std::complex<double>;

// Stress over strain amplitude of one cycle: in phase with the strain (real) and with its rate (imaginary).
struct Harmonics {
  Complex first, third;
};

struct Oscillation {
  double amplitude, frequency;
  int n_steps;  // of a cycle

  double phase(int step) const { return 2.0 * std::numbers::pi * step / n_steps; }
  double strain(int step) const { return amplitude * std::sin(phase(step)); }

  Harmonics cycle(Specimen& specimen) const {
    const double dt = 2.0 * std::numbers::pi / (frequency * n_steps);
    const double weight = 2.0 / (amplitude * n_steps);
    Harmonics sum{};
    for (int step = 1; step <= n_steps; ++step) {
      specimen.advance(Flow::simple_shear, strain(step) - strain(step - 1), dt);
      const double stress = weight * specimen.read().shear_stress;
      sum.first += stress * Complex(std::sin(phase(step)), std::cos(phase(step)));
      sum.third += stress * Complex(std::sin(3.0 * phase(step)), std::cos(3.0 * phase(step)));
    }
    return sum;
  }
};

struct LastCycle {
  Harmonics harmonics;
  int n_cycles;
  bool steady;
};

LastCycle shake(const OscillationSettings& settings, const Oscillation& oscillation, Specimen specimen) {
  LastCycle last{oscillation.cycle(specimen), 1, false};
  while (!last.steady && last.n_cycles < settings.largest_cycles) {
    const Complex before = last.harmonics.first;
    last.harmonics = oscillation.cycle(specimen);
    ++last.n_cycles;
    last.steady = last.n_cycles >= settings.smallest_cycles &&
                  std::abs(last.harmonics.first - before) <= settings.tolerance * std::abs(before);
  }
  return last;
}

// The kernel is of first order in time: it lags by half a step, which would hide a small G' next to a large G''. Twice the
// result of half the step less that of the whole is of second order.
LastCycle extrapolated(const OscillationSettings& settings, Oscillation oscillation, const Specimen& fresh) {
  const LastCycle coarse = shake(settings, oscillation, fresh);
  oscillation.n_steps *= 2;
  LastCycle fine = shake(settings, oscillation, fresh);
  fine.harmonics.first = 2.0 * fine.harmonics.first - coarse.harmonics.first;
  fine.harmonics.third = 2.0 * fine.harmonics.third - coarse.harmonics.third;
  fine.steady = fine.steady && coarse.steady;
  return fine;
}

void append(const Oscillation& oscillation, const LastCycle& last, const Specimen& fresh, Table& table) {
  const Complex modulus = last.harmonics.first;
  Row row;
  row.add("angular_frequency", oscillation.frequency)
      .add("strain_amplitude", oscillation.amplitude)
      .add("storage_modulus", modulus.real())
      .add("loss_modulus", modulus.imag())
      .add("loss_angle", std::arg(modulus) * 180.0 / std::numbers::pi)
      .add("complex_viscosity", std::abs(modulus) / oscillation.frequency)
      .add("third_harmonic", std::abs(last.harmonics.third) / std::abs(modulus));
  row.add("cycles", last.n_cycles).add("steady", last.steady ? 1.0 : 0.0);
  if (const auto maxwell = maxwell_limit(fresh.material(), fresh.volume_ratio())) {
    const DynamicModuli truth = dynamic_moduli(*maxwell, oscillation.frequency);
    row.add("analytic_storage_modulus", truth.storage).add("analytic_loss_modulus", truth.loss);
  }
  row.append_to(table);
}

}  // namespace

Measurement measure_oscillation(const Material& material, const OscillationSettings& settings) {
  Measurement result;
  const Specimen fresh = loaded_specimen(material, settings.pressure);
  int n_unsteady = 0;
  for (const double amplitude : settings.amplitudes)
    for (const double frequency : settings.frequencies) {
      const int n_for_strain = count_steps(2.0 * std::numbers::pi * amplitude, settings.strain_per_step);
      const Oscillation oscillation{amplitude, frequency, std::max(settings.steps_per_cycle, n_for_strain)};
      const LastCycle last = extrapolated(settings, oscillation, fresh);
      append(oscillation, last, fresh, result.table);
      n_unsteady += last.steady ? 0 : 1;
    }
  if (n_unsteady > 0)
    result.remarks.push_back(fmt::format("{} of {} rows were still changing after {} cycles (column steady is 0)",
                                         n_unsteady, result.table.rows.size(), settings.largest_cycles));
  return result;
}

}  // namespace bulkley::rheometer
