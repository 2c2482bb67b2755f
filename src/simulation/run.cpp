#include "simulation/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "integrator/diagnostics.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/files/text_file.hpp"
#include "kernel/stress_update.hpp"
#include "parallel/log.hpp"
#include "simulation/outputs/output.hpp"
#include "simulation/setup.hpp"
#include "simulation/stop_criteria.hpp"

namespace bulkley {

namespace {

// A run whose steps are slow is given that many times its slowest.
constexpr double slow_steps = 20.0;

// After a timeout, until readers on other hosts must have seen what the watchdog has written, s.
constexpr double time_to_tell = 60.0;

// status.json says why the run ends, by the watchdog's thread.
auto last_act_of(const Run& run) {
  return [folder = run.options.folder, started = run.progress.started, rank = run.comm.rank()](const std::string& sentence) {
    mark_unresponsive_alone(folder, sentence, started, rank);
  };
}

}  // namespace

Run::Run(const Comm& run_comm, const Scene& run_scene, const RunOptions& run_options)
    : comm(run_comm),
      scene(run_scene),
      options(run_options),
      progress(progress_at_start(comm, scene, options)),
      watchdog(comm) {
  clock.start = last_checkpoint.wall_time = MPI_Wtime();
  progress.started = broadcast_text(comm, progress.started);
  for (const NamedMaterial& material : scene.materials)
    if (!material.caveat.empty()) warn(fmt::format("material '{}': {}", material.name, material.caveat));
  const GlobalIndex restart_step = options.restart ? restore() : start();
  clock.first_step = state.step;
  clock.first_time = state.time;
  balancer = std::make_unique<Balancer>(comm, scene.partition, CostMeter(state.cost), state.step);
  outputs = outputs_of(*this, restart_step);
  stops = stop_criteria_of(*this);
}

Run::~Run() = default;

GlobalIndex Run::start() {
  const auto watch = watch_start();
  check_bodies(scene, shared_survey(comm));
  state.cost = assumed_cost(scene);
  solver = start_solver(comm, scene, &progress.warnings);
  state.bounds = solver->bounds();
  begin_energy_budget();
  const std::string fault = fixed_step_fault(scene.time_stepping, scene.grid.cell_size, state.bounds);
  if (!fault.empty()) {
    if (!scene.time_stepping.allow_unstable) throw UsageError(fault);
    warn(fault);
  }
  root_guard(comm, [&] { write_text_atomically(path_in(options.folder, "scene.toml"), scene.effective_text); });
  return -1;
}

// State and particles of a checkpoint: each rank reads an equal share in the order of the file. Then the partition is made,
// then particles go to their ranks.
ParticleSet Run::load(const std::string& file) {
  const CheckpointHeader header = read_header(comm, file);
  expect_materials(file, header.material_names, scene);
  const std::string changes = expect_same_scene(file, header.scene_text, scene, options.changed_scene);
  if (!changes.empty()) warn(changes);
  try {
    state = load_state(header.step, header.time, header.reals, header.integers);
  } catch (const RunError& error) {
    throw RunError(fmt::format("cannot read '{}': {}", file, error.what()));
  }
  ParticleSet particles = no_particles(scene);
  const EvenShare share = even_share(comm, header.n_particles);
  const bool has_stress = read_checkpoint(comm, file, share.first, share.count(), particles);
  collective_guard(comm, [&] {
    expect_inside(scene.grid, particles, file);
    if (!has_stress) set_stress(explicit_materials(scene), particles);
  });
  return particles;
}

GlobalIndex Run::restore() {
  const auto watch = watch_restart();
  ParticleSet particles = no_particles(scene);
  std::string file = options.restart_file;
  if (file.empty()) {
    std::vector<std::string> warnings;
    const auto latest = read_latest_checkpoint(comm, options.folder, warnings,
                                               [&](const std::string& candidate) { particles = load(candidate); });
    for (const std::string& warning : warnings) warn(warning);
    if (!latest) throw UsageError(fmt::format("{}: there is no whole checkpoint to restart from", options.folder));
    file = *latest;
  } else {
    particles = load(file);
  }
  fit_frame_tick(state, scene.output.frame_interval);
  state.cost.n_exchanges = scene.transfer.n_exchanges();
  const auto n_materials = static_cast<int>(scene.materials.size());
  const TileCensus census = take_census(scene.grid, particles, n_materials);
  Partition partition = first_partition(comm, scene, census, state.cost, &progress.warnings);
  solver = std::make_unique<Solver>(comm, physics_of(scene), std::move(partition), std::move(particles), state.bounds);
  solver->load_forces(state.force_reals, state.force_integers);
  solver->load_force_fields([&](BoxFields& box) { return read_box(comm, file, box); });
  ContactImpulses impulses = no_contact_impulses(solver->physics());
  if (state.contact_impulses.size() == impulses.words().size()) {
    impulses.set_words(state.contact_impulses);
    solver->set_contact_impulses(impulses);
  } else {  // the scene has other colliders or gauges now
    state.history_time = state.time;
  }
  if (!solver->set_energy_words(state.energy_words)) {
    begin_energy_budget();
    warn(fmt::format("{} holds no energy budget of this scene: the one in history.csv begins at t = {:g} s", file,
                     state.time));
  }
  last_checkpoint.file = file;
  last_checkpoint.step = state.step;
  progress.checkpoint_time = state.time;
  remove_checkpoints_after(comm, options.folder, state.step, scene.checkpoint.keep);
  root_guard(comm, [&] { write_text_atomically(path_in(options.folder, "scene.toml"), scene.effective_text); });
  log(fmt::format("continuing from {} at step {}, t = {:g} s", file, state.step, state.time));
  return state.step;
}

Watchdog::Watch Run::watch_start() {
  const double limit = scene.time_stepping.step_timeout;
  const auto tell = [folder = options.folder, rank = comm.rank(), told = progress](const std::string& sentence) {
    Status status{RunState::failed, 0, 0.0, "", sentence, told};
    status.in_set_up = status.unresponsive = true;
    write_first_failure_alone(folder, status, rank);
  };
  return watchdog.watch(
      {limit, limit,
       [=, rank = comm.rank(), n_ranks = comm.size()] {
         return fmt::format(
             "the start of the run has taken longer than {:g} s (time.step_timeout), says rank {} of {}: the file "
             "system or another rank does not answer, or the machine is too slow",
             limit, rank, n_ranks);
       },
       [] { return std::string(", at the start of the run"); }, tell});
}

Watchdog::Watch Run::watch_restart() {
  const double limit = scene.checkpoint.timeout;
  const std::string from =
      options.restart_file.empty() ? "the newest checkpoint of " + options.folder : options.restart_file;
  return watchdog.watch({limit, limit,
                         [=, rank = comm.rank(), n_ranks = comm.size()] {
                           return fmt::format(
                               "starting from {} has taken longer than {:g} s (checkpoint.timeout), says rank {} of {}: the "
                               "file system or another rank does not answer",
                               from, limit, rank, n_ranks);
                         },
                         [=] { return fmt::format(", starting from {}", from); }, last_act_of(*this)});
}

Watchdog::Watch Run::watch_write(const std::string& file) {
  const double limit = scene.checkpoint.timeout;
  const std::string hint = checkpoint_hint();
  return watchdog.watch({limit, 2.0 * last_checkpoint.seconds,
                         [=, rank = comm.rank(), n_ranks = comm.size()] {
                           return fmt::format(
                               "writing '{}' has taken longer than {:g} s (checkpoint.timeout), says rank {} of {}: the "
                               "file system or another rank does not answer; {}",
                               file, limit, rank, n_ranks, hint);
                         },
                         [=] { return fmt::format(", writing '{}'; {}", file, hint); }, last_act_of(*this)});
}

Watchdog::Watch Run::watch_step() {
  const double limit = step_limit();
  const GlobalIndex step = state.step + 1;
  const std::string hint = checkpoint_hint();
  const PhaseTimes& times = std::as_const(*solver).times();
  return watchdog.watch(
      {limit, 2.0 * clock.slowest_step,
       [=, rank = comm.rank(), n_ranks = comm.size(), &times] {
         return fmt::format(
             "step {} has taken longer than {:g} s (time.step_timeout); rank {} of {}, which says this, is in the phase {}: "
             "another rank does not answer, or the machine is too slow; {}",
             step, limit, rank, n_ranks, current_phase(times), hint);
       },
       [=, &times] { return fmt::format(", in step {}, in the phase {}; {}", step, current_phase(times), hint); },
       last_act_of(*this)});
}

void Run::begin_energy_budget() {
  const Diagnostics now = diagnostics();
  state.energy_start = {now.kinetic_energy, now.elastic_energy, now.dissipated_energy};
}

Diagnostics Run::diagnostics() const { return diagnose(comm, solver->physics(), solver->particles()); }

bool Run::at_end() const {
  return state.time >= scene.time_stepping.end_time || (options.max_steps >= 0 && state.step >= options.max_steps);
}

double Run::next_landing() const {
  const double interval = scene.output.frame_interval;
  if (interval <= 0.0) return scene.time_stepping.end_time;
  const double end = scene.time_stepping.end_time;
  return std::min(end, next_frame_time(state, interval, end));
}

void Run::log(const std::string& text) const {
  if (!options.quiet) log_line(comm, text);
}

void Run::warn(const std::string& text) {
  if (comm.is_root()) fmt::print(stderr, "warning: {}\n", text);
  if (progress.warnings.size() < most_warnings_kept) progress.warnings.push_back(text);
}

std::string Run::checkpoint_hint() const {
  return last_checkpoint.file.empty() ? "there is no checkpoint yet" : "the last good checkpoint is " + last_checkpoint.file;
}

Status Run::status(RunState run_state, const std::string& reason) const {
  Status status{run_state, state.step, state.time, last_checkpoint.file, reason, progress};
  status.progress.longest_silence = longest_silence();
  update_clock(state, clock, status.progress);
  return status;
}

double Run::step_limit() const {
  const double least = scene.time_stepping.step_timeout;
  return least > 0.0 ? std::max(least, slow_steps * clock.slowest_step) : 0.0;
}

double Run::longest_silence() const {
  const double step = step_limit(), write = scene.checkpoint.timeout;
  return step > 0.0 && write > 0.0 ? std::max(step, write) + time_to_tell : 0.0;
}

HaloTraffic Run::halo_traffic() const {
  return {max_global(comm, solver->halo_bytes()), sum_global(comm, solver->halo_bytes())};
}

}  // namespace bulkley
