#include "simulation/simulation.hpp"
#include "rebalance/share.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "bulkley/version.hpp"
#include "config/duration.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/files/text_file.hpp"
#include "io/files/write_watchdog.hpp"
#include "io/frames/frame.hpp"
#include "io/status/history.hpp"
#include "io/status/status.hpp"
#include "parallel/signals.hpp"
#include "rebalance/balancer.hpp"
#include "simulation/run_folder.hpp"
#include "simulation/run_report.hpp"
#include "simulation/setup.hpp"
#include "simulation/simulation_state.hpp"
#include "stepping/failure.hpp"

namespace bulkley {

namespace {

constexpr const char* stop_file = "STOP";
constexpr double seconds_between_looks_for_stop = 1.0;    // a look costs a shared file system about a millisecond
constexpr double walltime_before_first_checkpoint = 0.1;  // part of the whole
constexpr double cells_around_failure = 6.0;
constexpr std::size_t most_warnings_kept = 20;  // in status.json
// status.json is renewed once the program has run as long again, then at the longer interval: each costs a flush to disk.
constexpr double shortest_status_interval = 5.0, longest_status_interval = 20.0;  // s

// Owns one run; the constructor brings it to its first step, `run` to its end.
class Simulation {
 public:
  Simulation(const Comm& comm, const Scene& scene, const RunOptions& options)
      : comm_(comm),
        scene_(scene),
        options_(options),
        progress_(progress_at_start(comm, scene, options)),
        watchdog_(comm, scene.checkpoint.timeout) {
    clock_.start = last_progress_ = last_checkpoint_time_ = last_status_ = MPI_Wtime();
    for (const NamedMaterial& material : scene_.materials)
      if (!material.caveat.empty()) warn(fmt::format("material '{}': {}", material.name, material.caveat));
    const GlobalIndex restart_step = options_.restart ? restore() : start();
    clock_.first_step = state_.step;
    clock_.first_time = state_.time;
    balancer_ = std::make_unique<Balancer>(comm_, scene_.partition, state_.cost, state_.step);
    history_ = std::make_unique<History>(comm_, options_.folder, history_columns(scene_.colliders), restart_step);
    prepare_colliders();
    frames_ = std::make_unique<FrameSeries>(comm_, options_.folder, restart_step);
    for (const std::string& warning : frames_->warnings()) warn(warning);
  }

  RunOutcome run();
  std::string save_neighbourhood(const StepFailure& failure);
  const SimulationState& state() const { return state_; }
  /// With phases and memory as the last renewal of status.json knew them. Not collective.
  Status status(RunState state, const std::string& reason) const {
    Status status{state, state_.step, state_.time, last_checkpoint_, reason, progress_};
    update_clock(state_, clock_, status.progress);
    return status;
  }
  std::string comfort() const {
    return last_checkpoint_.empty() ? "there is no checkpoint yet" : "the last good checkpoint is " + last_checkpoint_;
  }

 private:
  GlobalIndex start();
  ParticleSet load(const std::string& file);
  GlobalIndex restore();
  void prepare_colliders();
  void write_start();
  bool at_end() const;
  Request request();
  double next_output() const;
  void take_step();
  void balance();
  HaloTraffic halo_traffic() const {
    return {max_global(comm_, solver_->halo_bytes()), sum_global(comm_, solver_->halo_bytes())};
  }
  void write_frame_if_due(bool landed);
  void write_frame_now(const TileValues* tiles);
  void write_history(const StepReport* report);
  void save_checkpoint();
  bool checkpoint_due(Request request) const;
  void report_progress(const TimeStepPlan& plan);
  void renew_status(RunState state, const std::string& reason);
  void finish(RunState state, const std::string& reason);
  std::string reason_to_stop(Request request) const;
  void say(const std::string& text) const {
    if (!options_.quiet) log_line(comm_, text);
  }
  void warn(const std::string& text) {
    if (comm_.is_root()) fmt::print(stderr, "warning: {}\n", text);
    if (progress_.warnings.size() < most_warnings_kept) progress_.warnings.push_back(text);
  }

  const Comm& comm_;
  const Scene& scene_;
  const RunOptions& options_;
  std::unique_ptr<Solver> solver_;
  std::unique_ptr<Balancer> balancer_;
  std::unique_ptr<History> history_;
  std::unique_ptr<FrameSeries> frames_;
  ColliderSurfaces colliders_;  // none in runs without frames
  SimulationState state_;
  RunClock clock_;
  StepReport report_;
  std::string last_checkpoint_;
  GlobalIndex checkpoint_step_ = -1;   // of the last checkpoint on disk
  double last_checkpoint_time_ = 0.0;  // MPI_Wtime, root's clock decides
  double checkpoint_seconds_ = 0.0;    // what the last one took
  double slowest_step_ = 0.0;          // s, with its output, for the wall-time stop
  double last_look_for_stop_ = 0.0;    // MPI_Wtime
  double last_progress_ = 0.0;
  double last_status_ = 0.0;  // MPI_Wtime, root's clock decides
  RunProgress progress_;
  WriteWatchdog watchdog_;
  GlobalIndex history_step_ = 0;   // of the last row
  double history_stepping_ = 0.0;  // clock_.stepping at the last row
};

GlobalIndex Simulation::start() {
  check_bodies(scene_, shared_counter(comm_));
  state_.cost = assumed_cost(scene_);
  solver_ = start_solver(comm_, scene_);
  state_.bounds = solver_->bounds();
  const std::string fault = fixed_step_fault(scene_.time_stepping, scene_.grid.cell_size, state_.bounds);
  if (!fault.empty()) {
    if (!scene_.time_stepping.allow_unstable) throw UsageError(fault);
    warn(fault);
  }
  root_guard(comm_, [&] { write_text_atomically(path_in(options_.folder, "scene.toml"), scene_.effective_text); });
  return -1;
}

// State and particles of a checkpoint: each rank reads an equal share in the order of the file. Then the partition is made,
// then particles go to their ranks.
ParticleSet Simulation::load(const std::string& file) {
  const CheckpointHeader header = read_header(comm_, file);
  expect_materials(file, header.material_names, scene_);
  const std::string changes = expect_same_scene(file, header.scene_text, scene_, options_.changed_scene);
  if (!changes.empty()) warn(changes);
  try {
    state_ = load_state(header.step, header.time, header.reals, header.integers);
  } catch (const RunError& error) {
    throw RunError(fmt::format("cannot read '{}': {}", file, error.what()));
  }
  ParticleSet particles(optional_fields(scene_));
  const EvenShare share = even_share(comm_, header.n_particles);
  read_checkpoint(comm_, file, share.first, share.count(), particles);
  collective_guard(comm_, [&] { expect_inside(scene_.grid, particles, file); });
  return particles;
}

GlobalIndex Simulation::restore() {
  ParticleSet particles(optional_fields(scene_));
  std::string file = options_.restart_file;
  if (file.empty()) {
    std::vector<std::string> warnings;
    const auto latest = read_latest_checkpoint(comm_, options_.folder, warnings,
                                               [&](const std::string& candidate) { particles = load(candidate); });
    for (const std::string& warning : warnings) warn(warning);
    if (!latest) throw UsageError(fmt::format("{}: there is no whole checkpoint to restart from", options_.folder));
    file = *latest;
  } else {
    particles = load(file);
  }
  fit_frame_tick(state_, scene_.output.frame_interval);
  state_.cost.n_exchanges = scene_.transfer.n_exchanges();
  const auto n_materials = static_cast<int>(scene_.materials.size());
  const TileCensus census = gather_census(comm_, take_census(scene_.grid, particles, n_materials));
  Partition partition = first_partition(comm_, scene_, census, state_.cost);
  solver_ = std::make_unique<Solver>(comm_, physics_of(scene_), std::move(partition), std::move(particles), state_.bounds);
  ContactImpulses impulses = no_contact_impulses(solver_->physics());
  if (state_.contact_impulses.size() == impulses.words().size()) {  // else the scene has other colliders now
    impulses.set_words(state_.contact_impulses);
    solver_->set_contact_impulses(impulses);
  }
  last_checkpoint_ = file;
  progress_.checkpoint_time = state_.time;
  checkpoint_step_ = state_.step;
  history_step_ = state_.step;
  remove_checkpoints_after(comm_, options_.folder, state_.step);
  root_guard(comm_, [&] { write_text_atomically(path_in(options_.folder, "scene.toml"), scene_.effective_text); });
  say(fmt::format("continuing from {} at step {}, t = {:g} s", file, state_.step, state_.time));
  return state_.step;
}

void Simulation::prepare_colliders() {
  const Bounds domain{scene_.grid.lower, scene_.grid.upper()};
  if (scene_.output.frame_interval > 0.0) colliders_ = ColliderSurfaces(scene_.colliders, domain);
  colliders_.write(comm_, options_.folder);
}

bool Simulation::at_end() const {
  return state_.time >= scene_.time_stepping.end_time || (options_.max_steps >= 0 && state_.step >= options_.max_steps);
}

// What this rank asks for. Times and files are the root's, so that one clock decides; the step's all-reduce makes it
// everyone's.
Request Simulation::request() {
  Request wanted = pending_request();
  if (!comm_.is_root()) return wanted;
  const double now = MPI_Wtime();
  const double interval = scene_.checkpoint.wall_interval;
  if (interval > 0.0 && now - last_checkpoint_time_ >= interval) wanted = std::max(wanted, Request::checkpoint);
  const double status_interval = std::clamp(now - clock_.start, shortest_status_interval, longest_status_interval);
  if (now - last_status_ >= status_interval) wanted = std::max(wanted, Request::status);
  if (options_.max_walltime > 0.0) {
    const double elapsed = now - options_.begin;
    const double reserve = 2.0 * checkpoint_seconds_ + 3.0 * slowest_step_ + 0.01 * options_.max_walltime;
    if (elapsed + reserve > options_.max_walltime) wanted = std::max(wanted, Request::stop_by_walltime);
    // One must have been written to know how long the last one will take.
    if (checkpoint_seconds_ == 0.0 && elapsed > walltime_before_first_checkpoint * options_.max_walltime)
      wanted = std::max(wanted, Request::checkpoint);
  }
  if (now - last_look_for_stop_ >= seconds_between_looks_for_stop) {
    last_look_for_stop_ = now;
    std::error_code none;
    if (std::filesystem::exists(path_in(options_.folder, stop_file), none)) wanted = std::max(wanted, Request::stop_by_file);
  }
  return wanted;
}

std::string Simulation::reason_to_stop(Request request) const {
  if (request == Request::stop_by_file) return fmt::format("by the file {}", path_in(options_.folder, stop_file));
  if (request == Request::stop_by_walltime)
    return fmt::format("before its wall time of {:g} s is over", options_.max_walltime);
  return "by a signal";
}

double Simulation::next_output() const {
  const double interval = scene_.output.frame_interval;
  if (interval <= 0.0) return scene_.time_stepping.end_time;
  return std::min(scene_.time_stepping.end_time, static_cast<double>(state_.frame_tick) * interval);
}

void Simulation::take_step() {
  const double before = MPI_Wtime();
  const double target = next_output();
  report_ = solver_->step(target - state_.time, static_cast<int>(request()), state_.controller, state_.time);
  ++state_.step;
  state_.time = report_.plan.lands ? target : state_.time + report_.plan.dt;
  state_.dt_last = report_.plan.dt;
  state_.n_removed += report_.bounds.n_removed;
  state_.n_migrated += report_.bounds.n_migrated;
  balance();
  state_.bounds = solver_->bounds();
  const double seconds = MPI_Wtime() - before;
  clock_.stepping += seconds;
  clock_.particle_steps += static_cast<double>(report_.bounds.n_particles);
  clock_.largest_share_steps += static_cast<double>(report_.bounds.largest_share);
}

void Simulation::balance() {
  const BalanceTotals before = balancer_->totals();
  balancer_->after_step(*solver_, state_.step);
  const BalanceTotals& after = balancer_->totals();
  state_.n_repartitions += after.n_repartitions - before.n_repartitions;
  state_.n_moved += after.n_moved - before.n_moved;
  state_.cost = balancer_->cost();
  if (const std::string warning = balancer_->take_warning(); !warning.empty()) warn(warning);
}

void Simulation::write_frame_if_due(bool landed) {
  const double interval = scene_.output.frame_interval;
  if (interval <= 0.0 || !landed || state_.time < static_cast<double>(state_.frame_tick) * interval) return;
  const double before = MPI_Wtime();
  const auto watch = watchdog_.watch(frame_path(options_.folder, state_.next_frame), comfort());
  if (scene_.output.tiles) {
    const TileTotals totals = tile_totals(comm_, scene_.grid, solver_->census(), state_.cost);
    const TileValues tiles{scene_.grid, solver_->partition().worker, totals.n_particles, totals.cost};
    write_frame_now(&tiles);
  } else {
    write_frame_now(nullptr);
  }
  frames_->add(comm_, state_.next_frame);
  ++state_.next_frame;
  ++state_.frame_tick;
  clock_.output += MPI_Wtime() - before;
}

void Simulation::write_frame_now(const TileValues* tiles) {
  const FrameInfo info{state_.next_frame, state_.step, state_.time, 0};
  if (scene_.output.grid) {
    const VecHandle values = solver_->node_values(state_.time);
    const PetscScalar* data = nullptr;
    BULKLEY_PETSC(VecGetArrayRead(values.get(), &data));
    const Grid& grid = solver_->grid();
    const GridNodes nodes{grid.geometry(),
                          grid.first(),
                          grid.count(),
                          {reinterpret_cast<const Node*>(data), static_cast<std::size_t>(grid.n_owned())}};
    write_frame(comm_, options_.folder, info, solver_->particles(), scene_.materials, scene_.output, &nodes, tiles,
                &colliders_);
    BULKLEY_PETSC(VecRestoreArrayRead(values.get(), &data));
  } else {
    write_frame(comm_, options_.folder, info, solver_->particles(), scene_.materials, scene_.output, nullptr, tiles,
                &colliders_);
  }
}

void Simulation::write_history(const StepReport* report) {
  const double before = MPI_Wtime();
  const Diagnostics diagnostics =
      diagnose(comm_, scene_.grid, scene_.transfer, scene_.gravity, scene_.materials, solver_->particles());
  const auto steps = static_cast<double>(std::max<GlobalIndex>(state_.step - history_step_, 1));
  const double seconds_per_step = (clock_.stepping - history_stepping_) / steps;
  const ContactForces contact{solver_->contact_impulses(), state_.time - state_.history_time};
  history_->write(comm_, history_row(state_, report, diagnostics, contact, halo_traffic(), comm_.size(), seconds_per_step));
  solver_->set_contact_impulses(no_contact_impulses(solver_->physics()));
  state_.history_time = state_.time;
  history_step_ = state_.step;
  history_stepping_ = clock_.stepping;
  clock_.output += MPI_Wtime() - before;
}

bool Simulation::checkpoint_due(Request request) const {
  const GlobalIndex interval = scene_.checkpoint.step_interval;
  return request == Request::checkpoint || (interval > 0 && state_.step % interval == 0);
}

void Simulation::save_checkpoint() {
  if (checkpoint_step_ == state_.step) return;
  const double before = MPI_Wtime();
  const auto watch = watchdog_.watch(checkpoint_path(options_.folder, state_.step), comfort());
  history_->sync(comm_);  // the rows before the checkpoint are as durable as itself
  CheckpointHeader header;
  header.step = state_.step;
  header.time = state_.time;
  header.scene_text = scene_.effective_text;
  header.code_version = fmt::format("{} ({})", version, git_commit);
  state_.contact_impulses = solver_->contact_impulses().words();
  save_state(state_, header.reals, header.integers);
  const std::vector<std::string> names = material_names(scene_);
  write_checkpoint(comm_, options_.folder, header, solver_->particles(), names, scene_.checkpoint.keep);
  last_checkpoint_ = checkpoint_path(options_.folder, state_.step);
  checkpoint_step_ = state_.step;
  progress_.checkpoint_time = state_.time;
  last_checkpoint_time_ = MPI_Wtime();
  checkpoint_seconds_ = last_checkpoint_time_ - before;
  clock_.output += checkpoint_seconds_;
  renew_status(RunState::running, "");
}

void Simulation::report_progress(const TimeStepPlan& plan) {
  const double now = MPI_Wtime();
  if (now - last_progress_ < scene_.output.progress_interval) return;
  last_progress_ = now;
  say(progress_line(state_, plan, scene_.time_stepping.end_time, clock_, comm_.size()));
}

void Simulation::renew_status(RunState state, const std::string& reason) {
  const auto watch = watchdog_.watch(path_in(options_.folder, "status.json"), comfort());
  update_progress(comm_, state_, clock_, solver_->times(), progress_);
  write_status(comm_, options_.folder, status(state, reason));
  last_status_ = MPI_Wtime();
}

void Simulation::finish(RunState state, const std::string& reason) {
  renew_status(state, reason);
  const std::string summary = run_summary(comm_, state_, clock_, solver_->times(), balancer_->totals(), halo_traffic());
  say(summary);
  say(fmt::format("{}: {}", name(state), reason));
}

void Simulation::write_start() {
  say(fmt::format("{}: {} particles, {} x {} x {} cells of {:g} m, {} ranks{}, output in {}",
                  scene_.title.empty() ? "run" : scene_.title, state_.bounds.n_particles, scene_.grid.n_cells[0],
                  scene_.grid.n_cells[1], scene_.grid.n_cells[2], scene_.grid.cell_size, comm_.size(),
                  boxes_text(solver_->partition().boxes), options_.folder));
  renew_status(RunState::running, "");
  if (options_.restart) return;
  write_frame_if_due(true);
  write_history(nullptr);
}

RunOutcome Simulation::run() {
  write_start();
  while (!at_end()) {
    const double before = MPI_Wtime();
    take_step();
    write_frame_if_due(report_.plan.lands);
    if (state_.step % scene_.output.history_interval == 0 || state_.time >= scene_.time_stepping.end_time)
      write_history(&report_);
    report_progress(report_.plan);
    slowest_step_ = std::max(slowest_step_, MPI_Wtime() - before);
    const auto asked = static_cast<Request>(report_.bounds.stop_request);
    if (asks_to_stop(asked) && !at_end()) {
      save_checkpoint();
      // Only now: whoever is told to stop and dies on the way must find it again.
      if (asked == Request::stop_by_file) root_guard(comm_, [&] { remove_file(path_in(options_.folder, stop_file)); });
      finish(RunState::stopped, fmt::format("{} at step {}; continue with: mpirun -n {} {}", reason_to_stop(asked),
                                            state_.step, comm_.size(), options_.continuation));
      return RunOutcome::stopped;
    }
    if (checkpoint_due(asked))
      save_checkpoint();
    else if (asked == Request::status)
      renew_status(RunState::running, "");
  }
  if (scene_.checkpoint.at_end || options_.max_steps >= 0) save_checkpoint();
  finish(RunState::finished, state_.time >= scene_.time_stepping.end_time
                                 ? std::string("reached the end time")
                                 : fmt::format("reached step {} (--max-steps)", state_.step));
  return RunOutcome::finished;
}

// Writes the particles about the place of the failure, as they are now, with all they hold; says where. Collective.
std::string Simulation::save_neighbourhood(const StepFailure& failure) {
  const ParticleSet& particles = solver_->particles();
  const double reach = cells_around_failure * scene_.grid.cell_size;
  std::vector<LocalIndex> near;
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    const Vec3 x = particles.vector(Field::position, p);
    if (failure.place ? (x - *failure.place).cwiseAbs().maxCoeff() <= reach : !x.allFinite()) near.push_back(p);
  }
  OutputSettings everything;
  everything.precision = FloatPrecision::float64;
  everything.fields = particle_field_names(particles);
  const std::string file = path_in(options_.folder, fmt::format("failure_{:09}.h5", state_.step + 1));
  const auto watch = watchdog_.watch(file, comfort());
  try {
    write_frame_file(comm_, file, {0, state_.step + 1, state_.time, 0}, particles.selected(near), scene_.materials,
                     everything);
  } catch (const RunError& error) {  // alike on every rank
    return fmt::format("what is around could not be saved: {}", error.what());
  }
  return fmt::format("what is around is saved in {}", file);
}

// An abort comes from one rank alone. The root goes first: it usually fails, too, and two would write the same file.
std::string last_words(const Comm& comm, const std::string& folder, const Simulation& simulation,
                       const std::string& message) {
  if (!comm.is_root()) std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::string text = fmt::format("; {}", simulation.comfort());
  write_status_alone(folder, simulation.status(RunState::failed, message + text));
  return text;
}

// Collective.
[[noreturn]] void fail(const Comm& comm, const std::string& folder, const Simulation& simulation, const std::string& fault) {
  const SimulationState& state = simulation.state();
  const std::string text =
      fmt::format("step {}, t = {:g} s: {}; {}", state.step + 1, state.time, fault, simulation.comfort());
  write_failure(comm, folder, simulation.status(RunState::failed, text));
  throw RunError(text);
}

}  // namespace

RunOutcome run_simulation(const Comm& comm, const Scene& scene, const RunOptions& options) {
  check_grid_output(scene, comm.size());
  check_colliders(scene);
  prepare_folder(comm, options);
  std::unique_ptr<Simulation> simulation;
  try {
    simulation = std::make_unique<Simulation>(comm, scene, options);
  } catch (const RunError& error) {  // alike on every rank
    write_failure(comm, options.folder,
                  {RunState::failed, 0, 0.0, "", error.what(), progress_at_start(comm, scene, options)});
    throw;
  }
  const AbortHook words([&](const std::string& message) { return last_words(comm, options.folder, *simulation, message); });
  try {
    return simulation->run();
  } catch (const StepFailure& failure) {  // alike on every rank
    fail(comm, options.folder, *simulation, fmt::format("{}; {}", failure.what(), simulation->save_neighbourhood(failure)));
  } catch (const RunError& error) {  // alike on every rank
    fail(comm, options.folder, *simulation, error.what());
  }
}

}  // namespace bulkley
