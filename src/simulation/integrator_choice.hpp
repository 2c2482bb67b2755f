#pragma once
// What either integrator would need for a scene, and which is cheaper: `bulkley check`.

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace bulkley {

struct BodyForecast;

/// What a step of imex costs, in explicit steps: a part that is always there, and iterations, whose number goes with the digits that
/// are asked for. Measured on a splash of cream with tolerances of 0.1, 0.01, 1e-3 and 1e-6: 3.7, 9.2, 16.2 and 49 iterations, 2.9, 3.9,
/// 4.4 and 7.1 explicit steps (docs/performance.md, "The implicit pressure"). A material at rest needs fewer.
inline constexpr double imex_base_cost = 2.5, pressure_iteration_cost = 0.12, iterations_per_digit = 5.0;
double imex_step_cost(const PressureSettings& settings);

/// And with implicit viscosity each of its iterations; so many are needed where dt is r times the viscous limit: about
/// viscous_iterations sqrt(r) (docs/theory.md, "Implicit viscosity").
inline constexpr double viscous_iteration_cost = 0.55, viscous_iterations = 2.1;

/// A run with one integrator, once the bodies move at their speeds U and shear at U / L.
struct IntegratorForecast {
  TimeStepLimit limit{};  ///< apart from impacts
  double n_steps = 0.0;
  double n_impact_steps = 0.0;  ///< of these, those that impacts add by their deformation
  double step_cost = 1.0;       ///< in explicit steps
  double cost = 0.0;            ///< of the run, likewise
};

struct IntegratorChoice {
  IntegratorForecast explicit_step, imex;
  IntegratorKind cheaper = IntegratorKind::explicit_step;
  std::string reason;              ///< why that one
  std::vector<std::string> notes;  ///< materials that stay explicit, and moduli that do not suit the scene's integrator
};

/// What of a material is integrated explicitly: its waves and its viscosity limit the step. Not collective.
Material explicit_part(const TimeStepSettings& settings, const Material& material);

/// Of a material's Newtonian stress, m^2/s; 0 without one. Not collective.
double kinematic_viscosity(const Material& material);

/// `bodies`: of the scene, in their order. Not collective.
IntegratorChoice compare_integrators(const Scene& scene, const std::vector<BodyForecast>& bodies);

}  // namespace bulkley
