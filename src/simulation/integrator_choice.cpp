#include "simulation/integrator_choice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "simulation/forecast.hpp"
#include "stepping/impact.hpp"

namespace bulkley {

namespace {

// A bulk modulus below it is softer than any liquid's or compact solid's: as a rule one lowered for the explicit step.
constexpr double true_bulk_modulus = 1e8;  // Pa

// The box that a body or collider fills.
using Box = std::pair<Vec3, Vec3>;

Box box_of(const Shape& shape) {
  const Bounds box = bounds(shape);
  return {box.lower, box.upper};
}

// What a body may meet, at rest: walls, colliders.
std::vector<Box> obstacles(const Scene& scene) {
  constexpr double endless = std::numeric_limits<double>::infinity();
  std::vector<Box> found;
  for (std::size_t face = 0; face < scene.faces.size(); ++face) {
    if (!behaviour(scene.faces[face].kind).contact) continue;
    const auto axis = static_cast<int>(face / 2);
    Box wall{Vec3::Constant(-endless), Vec3::Constant(endless)};
    if (face % 2 == 0)
      wall.second[axis] = scene.grid.lower[axis];
    else
      wall.first[axis] = scene.grid.upper()[axis];
    found.push_back(wall);
  }
  for (const Collider& collider : scene.colliders) found.push_back(box_of(collider.shape));
  return found;
}

// By boxes, in straight lines at the speed of their middles: gravity, spin and the motion of colliders change little before contact.
std::vector<Impact> impacts_of(const Scene& scene, const std::vector<BodyForecast>& bodies) {
  const std::vector<Box> rest = obstacles(scene);
  std::vector<Box> boxes;
  std::vector<Vec3> velocities;
  for (const Body& body : scene.bodies) {
    boxes.push_back(box_of(body.shape));
    velocities.push_back(StartMotion(scene.grid, body).velocity(0.5 * (boxes.back().first + boxes.back().second)));
  }
  int n_periodic = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) n_periodic += is_periodic(scene.faces, axis) ? 1 : 0;
  std::vector<Impact> impacts;
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    if (bodies[b].at_rest || std::isnan(bodies[b].reynolds)) continue;  // solids bounce
    double earliest = scene.time_stepping.end_time;
    const auto meet = [&](const Box& other, const Vec3& velocity) {
      if (!(velocity.norm() > 0.0)) return;  // NaN where a velocity_field has no value
      const auto time = first_contact(boxes[b].first, boxes[b].second, velocity, other.first, other.second);
      if (time) earliest = std::min(earliest, *time);
    };
    for (const Box& obstacle : rest) meet(obstacle, velocities[b]);
    for (std::size_t other = 0; other < boxes.size(); ++other)
      if (other != b) meet(boxes[other], velocities[b] - velocities[other]);
    if (earliest < scene.time_stepping.end_time)
      impacts.push_back({earliest, bodies[b].speed, bodies[b].size, n_periodic > 0 ? 1 : 2});
  }
  return impacts;
}

IntegratorForecast forecast_with(IntegratorKind kind, const Scene& scene, const std::vector<BodyForecast>& bodies,
                                 const std::vector<Impact>& impacts) {
  TimeStepSettings settings = scene.time_stepping;
  settings.integrator = kind;
  if (kind == IntegratorKind::explicit_step) {
    settings.viscosity = ViscosityKind::explicit_stress;
    // Shear waves alone bear more than the sound of a stiff fluid does: (T26b) for a single particle.
    if (scene.time_stepping.integrator == IntegratorKind::imex)
      settings.elastic_cfl =
          std::min(settings.elastic_cfl, 1.0 / std::sqrt(scene.transfer.gradient == GradientForm::mls ? 3.0 : 6.0));
  }
  settings = limited_by_fall(settings, scene.grid.cell_size, scene.gravity.norm());
  StepBounds bounds, viscous;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Material& material = scene.materials[bodies[b].material_index].material;
    bounds.motion.speed.include(bodies[b].speed, -1);
    bounds.motion.velocity_gradient.include(bodies[b].speed / bodies[b].size, -1);
    const Material limiting = explicit_part(settings, material);
    bounds.motion.wave_speed.include(wave_speed_at_rest(limiting), -1);
    bounds.motion.viscosity.include(kinematic_viscosity(limiting), -1);
    viscous.motion.viscosity.include(kinematic_viscosity(material), -1);
  }
  IntegratorForecast f;
  f.limit = time_step_limit(settings, scene.grid.cell_size, bounds, collider_speed(scene.grid, scene.colliders, 0.0, 0.0));
  f.n_steps = count_steps(settings, scene.grid.cell_size, settings.end_time, f.limit.dt, impacts);
  f.n_impact_steps = f.n_steps - count_steps(settings, scene.grid.cell_size, settings.end_time, f.limit.dt, {});
  if (kind == IntegratorKind::imex) f.step_cost = imex_step_cost(settings.pressure);
  if (settings.viscosity == ViscosityKind::implicit_stress && viscous.motion.viscosity.value > 0.0) {
    const double ratio = f.limit.dt / time_step_limit(settings, scene.grid.cell_size, viscous, 0.0).dt;
    f.step_cost += viscous_iteration_cost * viscous_iterations * std::sqrt(ratio);
  }
  f.cost = f.n_steps * f.step_cost;
  return f;
}

// Where impacts add a good part of the steps of a scene with imex: what a larger deformation limit would save. Empty elsewhere.
std::string note_of_deformation(const Scene& scene, const std::vector<BodyForecast>& bodies,
                                const std::vector<Impact>& impacts, const IntegratorForecast& imex) {
  constexpr double larger_limit = 0.3, good_part = 0.25;
  const TimeStepSettings& settings = scene.time_stepping;
  if (settings.integrator != IntegratorKind::imex || settings.mode == TimeStepMode::fixed ||
      settings.deformation_limit >= larger_limit || imex.n_impact_steps < good_part * imex.n_steps)
    return {};
  Scene looser = scene;
  looser.time_stepping.deformation_limit = larger_limit;
  const IntegratorForecast forecast = forecast_with(IntegratorKind::imex, looser, bodies, impacts);
  return fmt::format(
      "deformation limits the steps of impacts; with time.deformation_limit = {:g} there are {:.0f}, and more where a sheet "
      "tears, and "
      "volumes are less exact at an impact (docs/choose-dx-dt.md)",
      larger_limit, forecast.n_steps);
}

// Once a material, in the order of bodies and inflows.
template <class Visit>
void for_each_used(const Scene& scene, Visit visit) {
  std::set<std::size_t> seen;
  for (const Body& body : scene.bodies)
    if (seen.insert(body.material_index).second) visit(scene.materials[body.material_index]);
  for (const Inflow& inflow : scene.inflows)
    if (seen.insert(inflow.material_index).second) visit(scene.materials[inflow.material_index]);
}

std::vector<std::string> notes_of(const Scene& scene) {
  std::vector<std::string> notes, soft;
  const bool implicit = scene.time_stepping.integrator == IntegratorKind::imex;
  for_each_used(scene, [&](const NamedMaterial& named) {
    const auto law = volumetric_law(named.material);
    if (!law) {
      notes.push_back(fmt::format(
          "'{}': the stress of {} has no part that depends on volume alone: with imex it stays explicit, and its "
          "waves of {:.4g} m/s limit the step",
          named.name, law_name(named.material), wave_speed_at_rest(named.material)));
      return;
    }
    const auto* solid = std::get_if<FiniteViscoelastic>(&named.material);
    if (solid && solid->parameters.branch_bulk_modulus > 0.0)
      notes.push_back(fmt::format(
          "'{}': with imex its branch_bulk_modulus of {:.3g} Pa stays explicit, for it relaxes: waves of {:.4g} "
          "m/s limit the "
          "step",
          named.name, solid->parameters.branch_bulk_modulus, wave_speed_at_rest(without_volumetric_law(named.material))));
    if (implicit && law->bulk_modulus < true_bulk_modulus) soft.push_back(fmt::format("'{}'", named.name));
    if (!implicit && law->bulk_modulus > true_bulk_modulus)
      notes.push_back(fmt::format(
          "'{}': its bulk_modulus of {:.3g} Pa limits the explicit step; with time.integrator = \"imex\" it does not",
          named.name, law->bulk_modulus));
  });
  if (!soft.empty())
    notes.push_back(fmt::format(
        "{}: a bulk_modulus below {:.0e} Pa is softer than that of liquids and compact solids; with imex the true "
        "one needs no smaller step",
        fmt::join(soft, ", "), true_bulk_modulus));
  return notes;
}

}  // namespace

double imex_step_cost(const PressureSettings& settings) {
  return imex_base_cost + pressure_iteration_cost * iterations_per_digit * std::max(0.0, -std::log10(settings.tolerance));
}

Material explicit_part(const TimeStepSettings& settings, const Material& material) {
  const bool imex = settings.integrator == IntegratorKind::imex;
  const Material rest = imex && volumetric_law(material) ? without_volumetric_law(material) : material;
  return settings.viscosity == ViscosityKind::implicit_stress ? without_viscosity(rest) : rest;
}

double kinematic_viscosity(const Material& material) {
  return std::visit([](const auto& law) { return law.viscosity() / law.density(); }, material);
}

IntegratorChoice compare_integrators(const Scene& scene, const std::vector<BodyForecast>& bodies) {
  IntegratorChoice choice;
  const std::vector<Impact> impacts = impacts_of(scene, bodies);
  choice.explicit_step = forecast_with(IntegratorKind::explicit_step, scene, bodies, impacts);
  choice.imex = forecast_with(IntegratorKind::imex, scene, bodies, impacts);
  choice.notes = notes_of(scene);
  if (choice.imex.limit.limiter == Limiter::viscous)
    choice.notes.push_back(scene.time_stepping.viscosity == ViscosityKind::implicit_stress
                               ? "the viscosity of a law that the program has added stays explicit"
                               : "viscosity limits the step of imex; with time.viscosity = \"implicit\" it does not");
  if (std::string note = note_of_deformation(scene, bodies, impacts, choice.imex); !note.empty())
    choice.notes.push_back(std::move(note));
  const double ratio = choice.explicit_step.n_steps / choice.imex.n_steps, cost = choice.imex.step_cost;
  if (choice.imex.cost < choice.explicit_step.cost) {
    choice.cheaper = IntegratorKind::imex;
    choice.reason =
        fmt::format("its steps are {:.3g} times as long, and each costs about {:.2g} explicit ones", ratio, cost);
  } else {
    choice.reason = fmt::format("steps of imex are {:.3g} times as long, less than the {:.2g} explicit ones that each costs",
                                ratio, cost);
  }
  return choice;
}

}  // namespace bulkley
