#include "simulation/run_loop.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "simulation/outputs/output.hpp"
#include "simulation/outputs/status_output.hpp"
#include "simulation/setup.hpp"
#include "simulation/stop_criteria.hpp"

namespace bulkley {

namespace {

// What this rank asks for, as a number whose maximum over ranks decides: a Request, or to stop for the reason of the
// criterion number - Request::stop.
int request_of(Run& run) {
  int wanted = static_cast<int>(Request::none);
  for (const auto& output : run.outputs) wanted = std::max(wanted, static_cast<int>(output->wants(run)));
  for (std::size_t c = 0; c < run.stops.size(); ++c) {
    const Request request = run.stops[c]->wants(run);
    const int number = static_cast<int>(request) + (request == Request::stop ? static_cast<int>(c) : 0);
    wanted = std::max(wanted, number);
  }
  return wanted;
}

Request request_in(int number) { return static_cast<Request>(std::min(number, static_cast<int>(Request::stop))); }

void balance(Run& run) {
  const BalanceTotals before = run.balancer->totals();
  run.balancer->after_step(*run.solver, run.state.step);
  const BalanceTotals& after = run.balancer->totals();
  run.state.n_repartitions += after.n_repartitions - before.n_repartitions;
  run.state.n_moved += after.n_moved - before.n_moved;
  run.state.cost = run.balancer->cost();
  if (const std::string warning = run.balancer->take_warning(); !warning.empty()) run.warn(warning);
}

// Returns the strongest request of all ranks.
int take_step(Run& run) {
  const double before = MPI_Wtime();
  SimulationState& state = run.state;
  const double target = run.next_landing();
  run.last_step = run.solver->step({state.time, target - state.time, request_of(run), target}, state.controller);
  const StepReport& step = run.last_step;
  ++state.step;
  state.time = step.plan.lands ? target : state.time + step.plan.dt;
  state.dt_last = step.plan.dt;
  state.pressure.add(step.pressure);
  state.viscosity.add(step.viscosity);
  state.n_removed += step.bounds.transport.n_removed;
  state.n_migrated += step.bounds.transport.n_migrated;
  balance(run);
  state.bounds = run.solver->bounds();
  run.clock.stepping += MPI_Wtime() - before;
  run.clock.particle_steps += static_cast<double>(step.bounds.totals.n_particles);
  run.clock.largest_share_steps += static_cast<double>(step.bounds.transport.largest_share);
  return step.bounds.requests.caller;
}

void write_head(Run& run) {
  const Int3& n = run.scene.grid.n_cells;
  run.log(fmt::format("{}: {} particles, {} x {} x {} cells of {:g} m, {} ranks{}, output in {}",
                      run.scene.title.empty() ? "run" : run.scene.title, GlobalIndex{run.state.bounds.totals.n_particles},
                      n[0], n[1], n[2], run.scene.grid.cell_size, run.comm.size(), boxes_text(run.solver->partition().boxes),
                      run.options.folder));
  if (!run.solver->integrator().is_exact())
    for (const std::string& warning : rank_warnings(run.scene)) run.warn(warning);
}

void finish(Run& run, RunState state, const std::string& reason) {
  renew_status(run, state, reason);
  run.log(run_summary(run.comm, run.state, run.clock, run.solver->times(), run.balancer->totals(), run.halo_traffic()));
  run.log(fmt::format("{}: {}", name(state), reason));
}

}  // namespace

RunOutcome run_to_end(Run& run) {
  write_head(run);
  write_outputs(run, {RunEvent::start, Request::none});
  while (!run.at_end()) {
    const auto watch = run.watch_step();
    const double before = MPI_Wtime();
    const int asked = take_step(run);
    write_outputs(run, {RunEvent::step, request_in(asked)});
    const bool saved = run.last_checkpoint.step == run.state.step;
    run.clock.slowest_step =
        std::max(run.clock.slowest_step, MPI_Wtime() - before - (saved ? run.last_checkpoint.seconds : 0.0));
    if (request_in(asked) == Request::stop && !run.at_end()) {
      StopCriterion& criterion = *run.stops[static_cast<std::size_t>(asked - static_cast<int>(Request::stop))];
      write_outputs(run, {RunEvent::stop, Request::stop});
      criterion.obeyed(run);
      finish(run, RunState::stopped,
             fmt::format("{} at step {}; continue with: mpirun -n {} {}", criterion.reason(run), run.state.step,
                         run.comm.size(), run.options.continuation));
      return RunOutcome::stopped;
    }
  }
  write_outputs(run, {RunEvent::end, Request::none});
  finish(run, RunState::finished,
         run.state.time >= run.scene.time_stepping.end_time ? std::string("reached the end time")
                                                            : fmt::format("reached step {} (--max-steps)", run.state.step));
  return RunOutcome::finished;
}

}  // namespace bulkley
