#pragma once
// Keys of [time] of a scene.

#include <fmt/format.h>

#include "bulkley/config/keys.hpp"
#include "scene/petsc_option_keys.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

inline config::Names<TimeStepMode> names(config::Of<TimeStepMode>) {
  return {{"adaptive", TimeStepMode::adaptive}, {"fixed", TimeStepMode::fixed}};
}

inline config::Names<IntegratorKind> names(config::Of<IntegratorKind>) {
  return {{"explicit", IntegratorKind::explicit_step}, {"imex", IntegratorKind::imex}};
}

inline config::Names<PressureSolver> names(config::Of<PressureSolver>) {
  return {{"cg", PressureSolver::cg}, {"petsc", PressureSolver::petsc}};
}

inline const config::Keys<PressureSettings>& keys(config::Of<PressureSettings>) {
  using S = PressureSettings;
  static const auto table =
      config::Keys<S>("The implicit pressure of `time.integrator = \"imex\"` (docs/theory.md, \"Implicit pressure\").")
          .key("tolerance", &S::tolerance,
               {.about = "Residual of the pressure system, as a part of its right side, at which it counts as solved.",
                .range = config::between(1e-10, 0.1)})
          .key("max_iterations", &S::max_iterations,
               {.about = "Iterations of one solution beyond which the step is rejected and halved.",
                .unit = "iterations",
                .range = config::between(1.0, 1e5)})
          .key("stabilisation", &S::stabilisation,
               {.about = "How much pressures may differ within blocks of 2 x 2 x 2 cells, from 0, at will, to 1.",
                .range = config::between(0.0, 1.0)})
          .key("relaxation", &S::relaxation,
               {.about = "Part by which the volume ratios of a cell's particles approach their mean in a step.",
                .range = config::between(0.0, 1.0)})
          .key("contact_rounds", &S::contact_rounds,
               {.about = "Solutions a step, at most, to find which separating walls and colliders hold.",
                .unit = "solutions",
                .range = config::between(1.0, 100.0)})
          .key("solver", &S::solver,
               {.about =
                    "Own conjugate gradients, with which results are the same bits on any number of ranks, or a solver of "
                    "PETSc, with which they agree to the tolerance only."})
          .key("petsc_options", &S::petsc_options,
               {.about = "Options of PETSc's solver, such as `\"-bulkley_pressure_pc_type hypre\"`."})
          .only_with("solver = \"petsc\"", [](const S& s) { return s.solver == PressureSolver::petsc; })
          .check([](const config::Value& given, S& s, config::Faults& faults) {
            if (const std::string fault = petsc_options_fault(s.petsc_options, petsc_pressure_prefix,
                                                              "time.pressure.tolerance and .max_iterations say");
                !fault.empty())
              faults.add(given.find("petsc_options")->place,
                         fmt::format("'{}': {}", given.find("petsc_options")->path, fault));
          });
  return table;
}

inline config::Names<ViscosityKind> names(config::Of<ViscosityKind>) {
  return {{"explicit", ViscosityKind::explicit_stress}, {"implicit", ViscosityKind::implicit_stress}};
}

inline const config::Keys<ViscousSettings>& keys(config::Of<ViscousSettings>) {
  using S = ViscousSettings;
  static const auto table =
      config::Keys<S>("The implicit viscosity of `time.viscosity = \"implicit\"` (docs/theory.md, \"Implicit viscosity\").")
          .key("tolerance", &S::tolerance,
               {.about =
                    "Error of the change of velocity by viscosity in a step, as a part of that change, at which it counts "
                    "as found.",
                .range = config::between(1e-10, 0.1)})
          .key("max_iterations", &S::max_iterations,
               {.about = "Iterations beyond which the step is rejected and halved.",
                .unit = "iterations",
                .range = config::between(1.0, 1e5)});
  return table;
}

inline config::Names<DeformationCheck> names(config::Of<DeformationCheck>) {
  return {{"risky", DeformationCheck::risky}, {"always", DeformationCheck::always}};
}

inline const config::Keys<TimeStepSettings>& keys(config::Of<TimeStepSettings>) {
  using S = TimeStepSettings;
  const auto fixed = [](const S& s) { return s.mode == TimeStepMode::fixed; };
  static const auto table =
      config::Keys<S>("How long the run lasts, and its time step (docs/theory.md, \"Time step\").")
          .key("end", &S::end_time, {.about = "End of the run.", .unit = "s", .range = config::above(0.0), .required = true})
          .key(
              "integrator", &S::integrator,
              {.about = "Whether all forces are explicit, or the pressure is implicit: then the bulk modulus does not limit "
                        "the time step."})
          .key("pressure", &S::pressure, {.about = "The implicit pressure."})
          .only_with("integrator = \"imex\"", [](const S& s) { return s.integrator == IntegratorKind::imex; })
          .key("viscosity", &S::viscosity,
               {.about =
                    "Whether Newtonian stress (viscosity, background_viscosity, solvent_viscosity) is explicit or implicit: "
                    "then viscosity does not limit the time step."})
          .only_with("integrator = \"imex\"", [](const S& s) { return s.integrator == IntegratorKind::imex; })
          .key("viscous", &S::viscous, {.about = "The implicit viscosity."})
          .only_with("viscosity = \"implicit\"", [](const S& s) { return s.viscosity == ViscosityKind::implicit_stress; })
          .key("mode", &S::mode, {.about = "Whether the time step follows the limits or is fixed."})
          .key("dt", &S::dt_fixed, {.about = "The time step.", .unit = "s", .range = config::above(0.0), .required = true})
          .formerly("step")
          .only_with("mode = \"fixed\"", fixed)
          .key("allow_unstable", &S::allow_unstable,
               {.about = "Warn of a time step above the limits instead of refusing it."})
          .only_with("mode = \"fixed\"", fixed)
          .key("dt_initial", &S::dt_initial,
               {.about = "First time step; 0: a tenth of the limit at the start.",
                .unit = "s",
                .range = config::at_least(0.0)})
          .formerly("initial_step")
          .key("dt_max", &S::dt_max,
               {.about = "Largest time step; 0: no limit of its own.", .unit = "s", .range = config::at_least(0.0)})
          .formerly("largest_step")
          .key("dt_min", &S::dt_min,
               {.about = "Time step below which the run fails; 0: 1e-6 of the first limit.",
                .unit = "s",
                .range = config::at_least(0.0)})
          .formerly("smallest_step")
          .key("cfl", &S::cfl,
               {.about = "Largest part of a cell that a particle may cross in a step.", .range = config::above_to(0.0, 0.5)})
          .key("elastic_cfl", &S::elastic_cfl,
               {.about = "Largest part of a cell that an elastic wave may cross in a step.",
                .range = config::above_to(0.0, 1.1)})
          .key("viscous_cfl", &S::viscous_cfl,
               {.about = "Time step over dx^2 / (6 nu), nu the kinematic viscosity of the most viscous material with a "
                         "Newtonian stress.",
                .range = config::above_to(0.0, 1.0)})
          .key("deformation_limit", &S::deformation_limit,
               {.about = "Largest deformation of a particle in a step, as the norm of dt times its velocity gradient.",
                .range = config::above_to(0.0, 0.5)})
          .key("growth", &S::growth,
               {.about = "Factor by which a trial enlarges the time step.", .range = config::above_to(1.0, 2.0)})
          .key("trial_interval", &S::trial_interval,
               {.about = "Steps between trials.", .unit = "steps", .range = config::between(1.0, 1e6)})
          .key("deformation_check", &S::deformation_check,
               {.about = "Whether every step is checked for its deformation, or only trials and steps that come close to "
                         "the limit."})
          .key("step_timeout", &S::step_timeout,
               {.about = "Wall time after which a step with its output, or the start of a new run, that does not come to "
                         "its end, because a rank or a "
                         "node does not answer, ends the run with exit code 3; at least 20 times the slowest step so far. "
                         "0: never.",
                .unit = "s",
                .range = config::at_least(0.0),
                .duration = true})
          .key("smallest_volume_ratio", &S::smallest_volume_ratio,
               {.about = "The run fails when a particle is crushed to less than this part of its volume.",
                .range = config::above_to(0.0, 1.0)})
          .key("largest_volume_ratio", &S::largest_volume_ratio,
               {.about = "The run fails when a particle grows to more than this multiple of its volume.",
                .range = config::at_least(1.0)})
          .check([](const config::Value& given, S& s, config::Faults& faults) {
            constexpr double most_steps = 1e15;  // as many as a run can count, in the digits of the time
            for (const auto& [key, dt] : {std::pair("dt", s.dt_fixed), std::pair("dt_max", s.dt_max)})
              if (dt > 0.0 && s.end_time / dt > most_steps)
                faults.add(
                    given.find(key)->place,
                    fmt::format("'{}' is {}; it must be at least {:g}, or there are more than {:g} steps until "
                                "'{}.end' = {}",
                                given.find(key)->path, dt, s.end_time / most_steps, most_steps, given.path, s.end_time));
            if (s.dt_max == 0.0) return;
            for (const auto& [key, dt] : {std::pair("dt_min", s.dt_min), std::pair("dt_initial", s.dt_initial)})
              if (dt > s.dt_max)
                faults.add(given.find(key)->place,
                           fmt::format("'{}' is {}; it must be at most '{}' = {}", given.find(key)->path, dt,
                                       given.find("dt_max")->path, s.dt_max));
          });
  return table;
}

}  // namespace bulkley
