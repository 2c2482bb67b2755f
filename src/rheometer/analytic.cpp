#include "rheometer/analytic.hpp"

#include <array>
#include <cmath>

#include "material/return_map.hpp"

namespace bulkley::rheometer {

namespace {

// Steady state at elastic strain epsilon = s J / mu, per unit s or gamma; s is of the Cauchy stress.
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

// Stress of a Newtonian fluid over its viscosity and the rate.
double trouton_ratio(Flow flow) { return flow == Flow::simple_shear ? 1.0 : flow == Flow::uniaxial_extension ? 3.0 : 4.0; }

void add_newtonian(SteadyFlow& steady, double viscosity, Flow flow, double rate) {
  const double stress = trouton_ratio(flow) * viscosity * rate;
  steady.stress += stress;
  steady.small_strain_stress += stress;
  if (flow != Flow::simple_shear) steady.first_normal_difference += stress;
}

// s at a steady gamma, Pa.
double flow_stress(const HerschelBulkley& law, double gamma) {
  const auto rule = law.flow_rule();
  return rule.radius + rule.eta * std::pow(gamma, rule.h);
}

// The same with the structure in balance with the plastic shear rate sqrt(2) gamma.
double flow_stress(const ThixotropicHerschelBulkley& law, double gamma) {
  const ThixotropicHerschelBulkley::Parameters& p = law.parameters;
  const double rate_power = std::pow(std::sqrt(2.0) * gamma, p.rate_exponent);
  const bool breaks = p.kinetics == ThixotropicHerschelBulkley::Kinetics::thixotropic;
  const double build = p.build_up * (breaks ? 1.0 : rate_power), sum = build + p.breakdown * (breaks ? rate_power : 1.0);
  const double structure = sum > 0.0 ? build / sum : p.initial_structure;
  const auto strength = [&](double exponent, double residual) {
    return ThixotropicHerschelBulkley::strength(structure, exponent, residual);
  };
  return std::sqrt(2.0 / 3.0) * p.sigma_Y * strength(p.yield_exponent, p.residual_yield) +
         p.eta * strength(p.consistency_exponent, p.residual_consistency) * std::pow(gamma, p.h);
}

// By halving on s. The stress that the rate requires at s, less s itself, changes sign between 0 and the bracket's end.
template <class Law>
std::optional<SteadyFlow> viscoplastic_flow(const Law& law, Flow flow, double rate, double J) {
  const double mu = law.parameters.shear_modulus / J;
  if (!(mu > 0.0) || !std::isfinite(law.parameters.eta)) return std::nullopt;
  const auto wanted = [&](double s) { return flow_stress(law, rate / steady_shape(flow, s / mu).rate_ratio); };
  const Shape small = steady_shape(flow, 0.0);
  const double small_s = flow_stress(law, rate / small.rate_ratio);
  double lower = 0.0, upper = small_s;
  while (wanted(upper) > upper) upper *= 2.0;
  constexpr int halvings = 100;
  for (int k = 0; k < halvings; ++k) {
    const double s = 0.5 * (lower + upper);
    (wanted(s) > s ? lower : upper) = s;
  }
  const Shape shape = steady_shape(flow, upper / mu);
  SteadyFlow steady{upper * shape.stress, small_s * small.stress, upper * shape.normal_difference};
  add_newtonian(steady, law.parameters.background_viscosity, flow, rate);
  return steady;
}

// On s, too: both parts of the stress rise with it.
double herschel_bulkley_rate(const HerschelBulkley& law, double stress, double J) {
  const auto rule = law.flow_rule();
  const double mu = law.parameters.shear_modulus / J;
  const auto rate_at = [&](double s) {
    if (s <= rule.radius) return 0.0;
    return shear_shape(s / mu).rate_ratio * std::pow((s - rule.radius) / rule.eta, 1.0 / rule.h);
  };
  const auto stress_at = [&](double s) {
    return s * shear_shape(s / mu).stress + law.parameters.background_viscosity * rate_at(s);
  };
  double lower = 0.0, upper = stress;
  while (stress_at(upper) < stress) upper *= 2.0;
  constexpr int halvings = 100;
  for (int k = 0; k < halvings; ++k) {
    const double s = 0.5 * (lower + upper);
    (stress_at(s) < stress ? lower : upper) = s;
  }
  return rate_at(upper);
}

// Steady b of the upper convected model: b_aa = 1 / (1 - 2 lambda L_aa) in extension.
std::optional<SteadyFlow> oldroyd_flow(const OldroydB& law, Flow flow, double rate, double J) {
  const OldroydB::Parameters& p = law.parameters;
  if (p.form != OldroydB::Form::upper_convected) return std::nullopt;
  const double strain = p.relaxation_time * rate, G = p.shear_modulus / J;
  SteadyFlow steady{G * strain, G * strain, 2.0 * G * strain * strain};
  if (flow != Flow::simple_shear) {
    if (strain >= 0.5) return std::nullopt;
    const double across = flow == Flow::uniaxial_extension ? 1.0 / (1.0 + strain) : 1.0 / (1.0 + 2.0 * strain);
    steady.stress = steady.first_normal_difference = G * (1.0 / (1.0 - 2.0 * strain) - across);
    steady.small_strain_stress = trouton_ratio(flow) * G * strain;
  }
  add_newtonian(steady, p.solvent_viscosity, flow, rate);
  return steady;
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

}  // namespace

std::optional<SteadyFlow> steady_flow(const Material& material, Flow flow, double rate, double J) {
  if (const auto* law = std::get_if<HerschelBulkley>(&material)) return viscoplastic_flow(*law, flow, rate, J);
  if (const auto* law = std::get_if<ThixotropicHerschelBulkley>(&material)) return viscoplastic_flow(*law, flow, rate, J);
  if (const auto* law = std::get_if<OldroydB>(&material)) return oldroyd_flow(*law, flow, rate, J);
  if (const auto* law = std::get_if<Newtonian>(&material)) {
    SteadyFlow steady{};
    add_newtonian(steady, law->parameters.viscosity, flow, rate);
    return steady;
  }
  return std::nullopt;
}

std::optional<double> steady_shear_rate(const Material& material, double stress, double J) {
  const auto* law = std::get_if<HerschelBulkley>(&material);
  if (!law || !(law->parameters.shear_modulus > 0.0) || !(law->parameters.eta > 0.0) || std::isinf(law->parameters.eta))
    return std::nullopt;
  return herschel_bulkley_rate(*law, stress, J);
}

std::optional<SteadyFlow> solid_stress(const Material& material, Flow flow, double strain, double J) {
  const auto* law = std::get_if<NeoHookean>(&material);
  if (!law) return std::nullopt;
  return neo_hookean_stress(law->parameters.shear_modulus / J, flow, strain);
}

std::optional<MaxwellFluid> maxwell_limit(const Material& material, double J) {
  if (const auto* solid = std::get_if<NeoHookean>(&material))
    return MaxwellFluid{solid->parameters.shear_modulus / J, std::numeric_limits<double>::infinity(), 0.0};
  if (const auto* law = std::get_if<OldroydB>(&material)) {
    const OldroydB::Parameters& p = law->parameters;
    if (p.form != OldroydB::Form::upper_convected) return std::nullopt;
    return MaxwellFluid{p.shear_modulus / J, p.relaxation_time, p.solvent_viscosity};
  }
  const auto* law = std::get_if<HerschelBulkley>(&material);
  if (!law) return std::nullopt;
  const HerschelBulkley::Parameters& p = law->parameters;
  if (p.sigma_Y != 0.0 || p.h != 1.0 || !(p.shear_modulus > 0.0) || !std::isfinite(p.eta)) return std::nullopt;
  return MaxwellFluid{p.shear_modulus / J, p.eta * J / (2.0 * p.shear_modulus), p.background_viscosity};
}

DynamicModuli dynamic_moduli(const MaxwellFluid& fluid, double angular_frequency) {
  if (std::isinf(fluid.relaxation_time)) return {fluid.modulus, 0.0};
  const double x = angular_frequency * fluid.relaxation_time;
  return {fluid.modulus * x * x / (1.0 + x * x),
          fluid.modulus * x / (1.0 + x * x) + fluid.viscosity_beside * angular_frequency};
}

}  // namespace bulkley::rheometer
