#pragma once
// Measurements over time at a prescribed rate: start-up, relaxation after a step of strain, three intervals of rate.

#include <array>
#include <vector>

#include "rheometer/specimen.hpp"
#include "rheometer/table.hpp"

namespace bulkley::rheometer {

constexpr double instant = 1e-9;  ///< of the duration: the time that a jump takes, of strain or elastic

struct StartUpSettings {
  Flow flow = Flow::simple_shear;
  std::vector<double> rates;      ///< 1/s, > 0
  double strain = 1.0;            ///< at the end; Hencky strain in extension
  double strain_per_step = 2e-4;  ///< at most
  int n_points = 200;             ///< rows a rate, after the one at rest
  double pressure = 0.0;          ///< Pa, see loaded_specimen
};

struct RelaxationSettings {
  double strain = 0.01;    ///< shear, applied at once
  double duration = 10.0;  ///< s
  int n_steps = 20000;     ///< of the later part; early steps are a thousandth of the time since the step
  int n_points = 200;      ///< rows, evenly over the logarithm of time
  double pressure = 0.0;   ///< Pa
};

struct ThixotropySettings {
  std::array<double, 3> rates{};                   ///< 1/s, >= 0
  std::array<double, 3> durations{10., 10., 10.};  ///< s
  double strain_per_step = 2e-4;                   ///< at most
  int n_steps = 20000;                             ///< an interval, at least
  int n_points = 200;                              ///< rows an interval, after its first step
  double pressure = 0.0;                           ///< Pa
};

/// Stress over time and strain from rest. Throws RunError if the kernel refuses a step. Columns here and below:
/// docs/rheometer.md. Not collective.
Measurement measure_start_up(const Material& material, const StartUpSettings& settings);
/// Shear stress after a step of strain, at rest. Not collective.
Measurement measure_relaxation(const Material& material, const RelaxationSettings& settings);
/// Shear at a first, a second and a third rate, one after the other. Not collective.
Measurement measure_thixotropy(const Material& material, const ThixotropySettings& settings);

/// `n` times from duration / 1e5 to duration, evenly over their logarithm. Not collective.
std::vector<double> logarithmic_times(double duration, int n);

}  // namespace bulkley::rheometer
