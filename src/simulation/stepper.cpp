#include "bulkley/simulation/stepper.hpp"

#include "integrator/diagnostics.hpp"
#include "simulation/load_meshes.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

struct Stepper::Parts {
  const Comm& comm;
  Scene scene;
  std::unique_ptr<Solver> solver;
  TimeStepState state;
  double time = 0.0;
  double dt = 0.0;
};

Stepper::Stepper(const Comm& comm, const std::string& scene_text, const std::string& file_name,
                 const std::vector<std::string>& overrides)
    : parts_(new Parts{comm, parse_scene(scene_text, file_name, overrides), nullptr, {}}) {
  Scene& scene = parts_->scene;
  load_meshes(comm, scene, MeshesOf::everything);
  check_bodies(scene, shared_survey(comm));
  check_magnetics(scene);
  check_colliders(scene);
  check_rigid_bodies(scene);
  check_gauges(scene);
  check_petsc_options(comm, scene);
  parts_->solver = start_solver(comm, scene);
  const std::string fault = fixed_step_fault(scene.time_stepping, scene.grid.cell_size, parts_->solver->bounds());
  if (!fault.empty() && !scene.time_stepping.allow_unstable) throw UsageError(fault);
}

Stepper::~Stepper() = default;
Stepper::Stepper(Stepper&&) noexcept = default;

double Stepper::time() const { return parts_->time; }
GlobalIndex Stepper::n_steps() const { return parts_->state.n_steps; }
double Stepper::dt() const { return parts_->dt; }
double Stepper::end_time() const { return parts_->scene.time_stepping.end_time; }

void Stepper::advance(double duration) {
  const double target = parts_->time + duration;
  while (parts_->time < target) {
    const StepReport report = parts_->solver->step({parts_->time, target - parts_->time}, parts_->state);
    parts_->dt = report.plan.dt;
    parts_->time = report.plan.lands ? target : parts_->time + report.plan.dt;
  }
}

const ParticleSet& Stepper::particles() const { return parts_->solver->particles(); }

Diagnostics Stepper::diagnostics() const { return diagnose(parts_->comm, parts_->solver->physics(), particles()); }

}  // namespace bulkley
