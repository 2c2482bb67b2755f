#include "magnetics/magnetisation.hpp"

#include <cmath>

namespace bulkley {
namespace {

// Closed forms lose the digits of small arguments, by 1/x or more; the series below these have an error under 1e-15.
constexpr double small_langevin = 0.1;
constexpr double small_rational = 0.01;

/// coth x - 1/x over x/3.
double langevin_ratio(double x) {
  const double q = x * x;
  if (x < small_langevin) return 1.0 - q * (1.0 / 15.0 - q * (2.0 / 315.0 - q * (1.0 / 1575.0 - q * (2.0 / 31185.0))));
  return 3.0 * (1.0 / std::tanh(x) - 1.0 / x) / x;
}

/// Three times the derivative of coth x - 1/x: 1 at 0.
double langevin_slope(double x) {
  const double q = x * x;
  if (x < small_langevin) return 1.0 - q * (1.0 / 5.0 - q * (2.0 / 63.0 - q * (1.0 / 225.0 - q * (2.0 / 3465.0))));
  const double sinh = std::sinh(x);  // infinite for large x, which leaves 3/x^2
  return 3.0 * (1.0 / q - 1.0 / (sinh * sinh));
}

/// ln(sinh x / x) over x^2/6.
double langevin_energy_ratio(double x) {
  const double q = x * x;
  if (x < small_langevin) return 1.0 - q * (1.0 / 30.0 - q * (2.0 / 945.0 - q * (1.0 / 6300.0 - q * (2.0 / 155925.0))));
  return 6.0 * (x + std::log1p(-std::exp(-2.0 * x)) - std::log(2.0 * x)) / q;
}

/// x - ln(1 + x) over x^2/2.
double froehlich_energy_ratio(double x) {
  if (x >= small_rational) return 2.0 * (x - std::log1p(x)) / (x * x);
  double sum = 0.0;
  for (int n = 9; n >= 2; --n) sum = 2.0 / n - x * sum;
  return sum;
}

/// x - (1 - exp(-x)) over x^2/2.
double exponential_energy_ratio(double x) {
  if (x >= small_rational) return 2.0 * (x + std::expm1(-x)) / (x * x);
  double sum = 1.0;
  for (int n = 9; n >= 3; --n) sum = 1.0 - x / n * sum;
  return sum;
}

}  // namespace

double Magnetisation::at(double H) const {
  const double x = susceptibility * H / saturation;
  switch (law) {
    case Law::linear:
      return susceptibility * H;
    case Law::langevin:
      return susceptibility * H * langevin_ratio(3.0 * x);
    case Law::froehlich_kennelly:
      return susceptibility * H / (1.0 + x);
    case Law::exponential:
      return -saturation * std::expm1(-x);
  }
  return 0.0;
}

double Magnetisation::slope(double H) const {
  const double x = susceptibility * H / saturation;
  switch (law) {
    case Law::linear:
      return susceptibility;
    case Law::langevin:
      return susceptibility * langevin_slope(3.0 * x);
    case Law::froehlich_kennelly:
      return susceptibility / ((1.0 + x) * (1.0 + x));
    case Law::exponential:
      return susceptibility * std::exp(-x);
  }
  return 0.0;
}

Magnetisation::Response Magnetisation::response(double H) const {
  const double x = susceptibility * H / saturation;
  switch (law) {
    case Law::linear:
      return {susceptibility * H, susceptibility};
    case Law::langevin: {
      if (3.0 * x < small_langevin) return {at(H), slope(H)};
      const double q = 9.0 * x * x, coth = 1.0 / std::tanh(3.0 * x);
      return {saturation * (coth - 1.0 / (3.0 * x)), 3.0 * susceptibility * (1.0 / q - (coth * coth - 1.0))};
    }
    case Law::froehlich_kennelly: {
      const double share = 1.0 / (1.0 + x);
      return {susceptibility * H * share, susceptibility * share * share};
    }
    case Law::exponential: {
      const double change = std::expm1(-x);
      return {-saturation * change, susceptibility * (1.0 + change)};
    }
  }
  return {0.0, 0.0};
}

double Magnetisation::co_energy(double H) const {
  const double x = susceptibility * H / saturation;
  const double linear = 0.5 * susceptibility * H * H;
  switch (law) {
    case Law::linear:
      return linear;
    case Law::langevin:
      return linear * langevin_energy_ratio(3.0 * x);
    case Law::froehlich_kennelly:
      return linear * froehlich_energy_ratio(x);
    case Law::exponential:
      return linear * exponential_energy_ratio(x);
  }
  return 0.0;
}

}  // namespace bulkley
