#include "simulation/outputs/history_output.hpp"

#include <algorithm>

#include "integrator/column_thickness.hpp"
#include "integrator/fronts.hpp"

namespace bulkley {

HistoryOutput::HistoryOutput(Run& run, GlobalIndex restart_step)
    : history_(run.comm, run.options.folder, history_columns(run.scene), restart_step), row_step_(run.state.step) {
  for (const Gauge& gauge : run.scene.output.gauges)
    gauge_areas_.push_back(gauge_area(run.scene.grid, gauge, run.scene.colliders));
}

bool HistoryOutput::is_due(const Run& run, const Occasion& occasion) const {
  if (occasion.event == RunEvent::start) return !run.options.restart;
  return occasion.event == RunEvent::step &&
         (run.state.step % run.scene.output.history_interval == 0 || run.state.time >= run.scene.time_stepping.end_time);
}

void HistoryOutput::write(Run& run) {
  const double before = MPI_Wtime();
  SimulationState& state = run.state;
  Diagnostics diagnostics = run.diagnostics();
  const EnergyAccount energies = energy_account(run.solver->energy_totals(), state.energy_start, diagnostics);
  const auto steps = static_cast<double>(std::max<GlobalIndex>(state.step - row_step_, 1));
  const double seconds_per_step = (run.clock.stepping - row_stepping_) / steps;
  const ContactForces contact{run.solver->contact_impulses(), state.time - state.history_time};
  const StepReport* step = state.step > run.clock.first_step ? &run.last_step : nullptr;
  RigidContact* const bodies = run.solver->rigid_bodies();
  const Measurements measured{thickness_decile(run.comm, run.scene.grid, run.scene.gravity, run.solver->particles(),
                                               diagnostics.lower, diagnostics.upper),
                              reaches(run.comm, run.scene.output.fronts, run.solver->particles()),
                              gauge_areas_,
                              run.solver->force_history(),
                              bodies ? bodies->history() : std::vector<std::vector<double>>{},
                              fed_figures(run.scene, *run.solver, state.time)};
  history_.write(run.comm, history_row(run.scene, state, step, diagnostics, energies, contact, measured, run.halo_traffic(),
                                       run.comm.size(), seconds_per_step));
  run.solver->set_contact_impulses(no_contact_impulses(run.solver->physics()));
  if (bodies) bodies->begin_history();
  run.progress.pressure = pressure_figures(state.pressure);
  run.progress.viscosity = viscosity_figures(state.viscosity);
  run.progress.volume_error = diagnostics.volume_error;
  state.pressure = {};
  state.viscosity = {};
  state.history_time = state.time;
  row_step_ = state.step;
  row_stepping_ = run.clock.stepping;
  run.clock.output += MPI_Wtime() - before;
}

}  // namespace bulkley
