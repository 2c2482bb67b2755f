#include "bulkley/rheometer/analytic.hpp"

#include <array>
#include <cmath>
#include <type_traits>

#include "bulkley/material/return_map.hpp"

namespace bulkley::rheometer {

namespace {

// Steady state at elastic strain epsilon = s / mu, per unit s or gamma.
struct Shape {
  double stress;             // driven stress / s
  double normal_difference;  // N_1 / s
  double rate_ratio;         // macroscopic rate / gamma
};

// x of b = epsilon n + x 1 with det b = 1.
double mean_of_b(double epsilon, double det_n) {
  return isochoric_mean<double>(0.5 * epsilon * epsilon, epsilon * epsilon * epsilon * det_n, 1.0 + epsilon, true);
}

// n = [[-2z, n12, 0], [n12, z, 0], [0, 0, z]] with ||n|| = 1; z from the balance of the flow's normal components, which is
// positive at z = 0 and negative at the other end.
Shape shear_shape(double epsilon) {
  double lower = -1.0 / std::sqrt(6.0), upper = 0.0, z = 0.0, x = 1.0;
  constexpr int halvings = 60;
  for (int k = 0; k < halvings; ++k) {
    z = 0.5 * (lower + upper);
    x = mean_of_b(epsilon, z * (z * z - 0.5));
    (3.0 * z * (x + epsilon * z) + (1.0 - 6.0 * z * z) * epsilon > 0.0 ? upper : lower) = z;
  }
  const double n12 = std::sqrt(0.5 * (1.0 - 6.0 * z * z));
  return {n12, -3.0 * z, 2.0 * x * n12 / (x + epsilon * z)};
}

using Diagonal = std::array<double, 3>;

double norm(const Diagonal& d) { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); }

Diagonal deviator_of(Diagonal d) {
  const double mean = (d[0] + d[1] + d[2]) / 3.0;
  for (double& each : d) each -= mean;
  return d;
}

// Steady: the deviator of D b + b D, D the rate of deformation per unit rate, is 2 x (gamma / rate) n. Its direction is
// found by repetition.
Shape extension_shape(const Diagonal& D, double epsilon) {
  Diagonal n = D;
  for (double& each : n) each /= norm(D);
  double x = 1.0, supply = 2.0 * norm(D);
  constexpr int cap = 10000;
  constexpr double tolerance = 1e-15;
  for (int k = 0; k < cap; ++k) {
    x = mean_of_b(epsilon, n[0] * n[1] * n[2]);
    Diagonal next;
    for (int a = 0; a < 3; ++a) next[a] = 2.0 * D[a] * (epsilon * n[a] + x);
    next = deviator_of(next);
    supply = norm(next);
    double change = 0.0;
    for (int a = 0; a < 3; ++a) {
      next[a] /= supply;
      change += std::fabs(next[a] - n[a]);
    }
    n = next;
    if (change < tolerance) break;
  }
  const double difference = n[0] - n[1];
  return {difference, difference, 2.0 * x / supply};
}

Shape steady_shape(Flow flow, double epsilon) {
  switch (flow) {
    case Flow::simple_shear:
      return shear_shape(epsilon);
    case Flow::uniaxial_extension:
      return extension_shape({1.0, -0.5, -0.5}, epsilon);
    case Flow::planar_extension:
      return extension_shape({1.0, -1.0, 0.0}, epsilon);
  }
  return {};
}

double flow_stress(const FlowRule& rule, double gamma) { return rule.radius + rule.eta * std::pow(gamma, rule.h); }

// By halving on s. The stress that the rate asks for at s, less s itself, changes sign between 0 and the bracket's end.
SteadyFlow herschel_bulkley_flow(const HerschelBulkley& law, Flow flow, double rate) {
  const FlowRule rule = law.flow_rule();
  const double mu = law.parameters.shear_modulus;
  const auto wanted = [&](double s) { return flow_stress(rule, rate / steady_shape(flow, s / mu).rate_ratio); };
  const Shape small = steady_shape(flow, 0.0);
  const double small_s = flow_stress(rule, rate / small.rate_ratio);
  double lower = 0.0, upper = small_s;
  while (wanted(upper) > upper) upper *= 2.0;
  constexpr int halvings = 100;
  for (int k = 0; k < halvings; ++k) {
    const double s = 0.5 * (lower + upper);
    (wanted(s) > s ? lower : upper) = s;
  }
  const Shape shape = steady_shape(flow, upper / mu);
  return {upper * shape.stress, small_s * small.stress, upper * shape.normal_difference};
}

double herschel_bulkley_rate(const HerschelBulkley& law, double stress) {
  const FlowRule rule = law.flow_rule();
  const double mu = law.parameters.shear_modulus;
  double lower = 0.0, upper = stress;
  while (upper * shear_shape(upper / mu).stress < stress) upper *= 2.0;
  constexpr int halvings = 100;
  for (int k = 0; k < halvings; ++k) {
    const double s = 0.5 * (lower + upper);
    (s * shear_shape(s / mu).stress < stress ? lower : upper) = s;
  }
  if (upper <= rule.radius) return 0.0;
  return shear_shape(upper / mu).rate_ratio * std::pow((upper - rule.radius) / rule.eta, 1.0 / rule.h);
}

bool flows_steadily(const HerschelBulkley& law) {
  return law.parameters.shear_modulus > 0.0 && std::isfinite(law.parameters.eta);
}

SteadyFlow neo_hookean_stress(double mu, Flow flow, double strain) {
  switch (flow) {
    case Flow::simple_shear:
      return {mu * strain, mu * strain, mu * strain * strain};
    case Flow::uniaxial_extension: {
      const double stress = mu * (std::exp(2.0 * strain) - std::exp(-strain));
      return {stress, 3.0 * mu * strain, stress};
    }
    case Flow::planar_extension: {
      const double stress = 2.0 * mu * std::sinh(2.0 * strain);
      return {stress, 4.0 * mu * strain, stress};
    }
  }
  return {};
}

// Calls `answer` if the material is of this law.
template <class Law, class Answer>
auto if_law(const Material& material, const Answer& answer) -> decltype(answer(std::declval<const Law&>())) {
  const auto* law = std::get_if<Law>(&material);
  return law ? answer(*law) : std::nullopt;
}

}  // namespace

std::optional<SteadyFlow> steady_flow(const Material& material, Flow flow, double rate) {
  return if_law<HerschelBulkley>(material, [&](const HerschelBulkley& law) -> std::optional<SteadyFlow> {
    if (!flows_steadily(law)) return std::nullopt;
    return herschel_bulkley_flow(law, flow, rate);
  });
}

std::optional<double> steady_shear_rate(const Material& material, double stress) {
  return if_law<HerschelBulkley>(material, [&](const HerschelBulkley& law) -> std::optional<double> {
    if (!flows_steadily(law) || law.parameters.eta == 0.0) return std::nullopt;
    return herschel_bulkley_rate(law, stress);
  });
}

std::optional<SteadyFlow> solid_stress(const Material& material, Flow flow, double strain) {
  return if_law<NeoHookean>(material, [&](const NeoHookean& law) -> std::optional<SteadyFlow> {
    return neo_hookean_stress(law.parameters.shear_modulus, flow, strain);
  });
}

std::optional<MaxwellFluid> maxwell_limit(const Material& material) {
  if (const auto* solid = std::get_if<NeoHookean>(&material))
    return MaxwellFluid{solid->parameters.shear_modulus, std::numeric_limits<double>::infinity()};
  return if_law<HerschelBulkley>(material, [&](const HerschelBulkley& law) -> std::optional<MaxwellFluid> {
    const HerschelBulkley::Parameters& p = law.parameters;
    if (p.sigma_Y != 0.0 || p.h != 1.0 || !flows_steadily(law)) return std::nullopt;
    return MaxwellFluid{p.shear_modulus, p.eta / (2.0 * p.shear_modulus)};
  });
}

DynamicModuli dynamic_moduli(const MaxwellFluid& fluid, double angular_frequency) {
  if (std::isinf(fluid.relaxation_time)) return {fluid.modulus, 0.0};
  const double x = angular_frequency * fluid.relaxation_time;
  return {fluid.modulus * x * x / (1.0 + x * x), fluid.modulus * x / (1.0 + x * x)};
}

}  // namespace bulkley::rheometer
