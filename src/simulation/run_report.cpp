#include "simulation/run_report.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "config/duration.hpp"
#include "integrator/magnetic_force.hpp"

namespace bulkley {

namespace {

bool has_contact(const Face& face) { return behaviour(face.kind).contact.has_value(); }

bool is_implicit(const Scene& scene) { return scene.time_stepping.integrator == IntegratorKind::imex; }
bool has_implicit_viscosity(const Scene& scene) { return scene.time_stepping.viscosity == ViscosityKind::implicit_stress; }

std::vector<std::string> columns_of_particles(const std::vector<std::string>& energies) {
  std::vector<std::string> columns{"step",
                                   "time [s]",
                                   "dt [s]",
                                   "limiter",
                                   "limiter_id",
                                   "trials",
                                   "accepted_trials",
                                   "rejected_steps",
                                   "unchecked_large_steps",
                                   "mass [kg]",
                                   "momentum_x [kg m/s]",
                                   "momentum_y [kg m/s]",
                                   "momentum_z [kg m/s]",
                                   "angular_momentum_x [kg m^2/s]",
                                   "angular_momentum_y [kg m^2/s]",
                                   "angular_momentum_z [kg m^2/s]",
                                   "kinetic_energy [J]",
                                   "elastic_energy [J]",
                                   "gravitational_energy [J]",
                                   "dissipated_energy [J]"};
  columns.insert(columns.end(), energies.begin(), energies.end());
  for (const char* name : {"center_of_mass_x [m]",
                           "center_of_mass_y [m]",
                           "center_of_mass_z [m]",
                           "lower_x [m]",
                           "lower_y [m]",
                           "lower_z [m]",
                           "upper_x [m]",
                           "upper_y [m]",
                           "upper_z [m]",
                           "max_speed [m/s]",
                           "max_velocity_gradient [1/s]",
                           "max_wave_speed [m/s]",
                           "min_volume_ratio",
                           "max_volume_ratio",
                           "volume_error",
                           "yielded_fraction",
                           "thickness_decile [cells]",
                           "particles",
                           "removed_particles",
                           "imbalance",
                           "repartitions",
                           "moved_particles",
                           "migrated_particles",
                           "halo_bytes_largest [B]",
                           "halo_bytes_mean [B]",
                           "wall_time_per_step [s]"})
    columns.emplace_back(name);
  return columns;
}

/// Those of EnergyAccount, but of colliders.
std::vector<std::string> columns_of_energies(const Scene& scene) {
  std::vector<std::string> columns{"gravity_work [J]"};
  if (scene.acceleration_field.given()) columns.emplace_back("acceleration_field_work [J]");
  if (scene.magnetics) columns.emplace_back("magnetic_field_work [J]");
  for (const char* name : {"to_grid_loss [J]", "time_integration_loss [J]", "to_grid_and_integration_loss [J]",
                           "from_grid_loss [J]", "removed_energy [J]"})
    columns.emplace_back(name);
  for (std::size_t f = 0; f < n_faces; ++f)
    if (has_contact(scene.faces[f]))
      for (const char* what : {"loss", "work"})
        columns.push_back(fmt::format("wall_{}.contact_{} [J]", face_names[f], what));
  columns.emplace_back("energy_residual [J]");
  return columns;
}

void add_energies(const Scene& scene, const EnergyAccount& energies, std::vector<HistoryValue>& row) {
  row.emplace_back(energies.gravity);
  for (const double work : energies.forces) row.emplace_back(work);
  for (const double loss :
       {energies.to_grid, energies.time_integration, energies.to_grid_and_integration, energies.from_grid, energies.removed})
    row.emplace_back(loss);
  for (std::size_t f = 0; f < n_faces; ++f)
    if (has_contact(scene.faces[f])) {
      row.emplace_back(energies.contact_loss[f]);
      row.emplace_back(energies.contact_work[f]);
    }
  row.emplace_back(energies.residual);
}

}  // namespace

std::vector<std::string> history_columns(const Scene& scene) {
  std::vector<std::string> columns = columns_of_particles(columns_of_energies(scene));
  if (is_implicit(scene))
    for (const char* name : {"pressure_iterations", "pressure_iterations_max", "contact_rounds"}) columns.emplace_back(name);
  if (has_implicit_viscosity(scene))
    for (const char* name : {"viscosity_iterations", "viscosity_iterations_max"}) columns.emplace_back(name);
  if (scene.magnetics) columns.insert(columns.end(), MagneticFigures::columns().begin(), MagneticFigures::columns().end());
  const auto add_vector = [&](const std::string& prefix, const char* quantity, const char* unit) {
    for (const char* axis : {"x", "y", "z"}) columns.push_back(fmt::format("{}.{}_{} {}", prefix, quantity, axis, unit));
  };
  for (const Collider& collider : scene.colliders) {
    add_vector(column_prefix(collider.name), "force", "[N]");
    add_vector(column_prefix(collider.name), "torque", "[N m]");
    for (const char* what : {"loss", "work"})
      columns.push_back(fmt::format("{}.contact_{} [J]", column_prefix(collider.name), what));
  }
  for (const RigidBody& body : scene.rigid_bodies) {
    for (const std::string& column : RigidContact::columns()) columns.push_back(column_prefix(body.name) + "." + column);
    for (const char* what : {"loss", "work"})
      columns.push_back(fmt::format("{}.contact_{} [J]", column_prefix(body.name), what));
  }
  for (const Front& front : scene.output.fronts) columns.push_back(column_prefix(front.name) + ".reach [m]");
  for (const Gauge& gauge : scene.output.gauges) {
    add_vector(column_prefix(gauge.name), "force", "[N]");
    columns.push_back(column_prefix(gauge.name) + ".pressure [Pa]");
  }
  for (const Inflow& inflow : scene.inflows) {
    const std::string prefix = column_prefix(inflow.name);
    for (const char* what : {"entered [kg]", "entered_by_particles [kg]", "entered_particles", "feed_particles",
                             "pushed_back_particles", "pressure [Pa]"})
      columns.push_back(fmt::format("{}.{}", prefix, what));
    add_vector(prefix, "force", "[N]");
    add_vector(prefix, "torque", "[N m]");
    add_vector(prefix, "feed_force", "[N]");
    for (const char* what : {"energy_brought", "contact_loss", "contact_work"})
      columns.push_back(fmt::format("{}.{} [J]", prefix, what));
  }
  return columns;
}

PressureFigures pressure_figures(const PressureTotals& totals) {
  const auto steps = static_cast<double>(std::max<GlobalIndex>(totals.n_steps, 1));
  return {static_cast<double>(totals.n_iterations) / steps, totals.most_iterations,
          static_cast<double>(totals.n_rounds) / steps};
}

ViscosityFigures viscosity_figures(const ViscosityTotals& totals) {
  const auto steps = static_cast<double>(std::max<GlobalIndex>(totals.n_steps, 1));
  return {static_cast<double>(totals.n_iterations) / steps, totals.most_iterations};
}

std::vector<HistoryValue> history_row(const Scene& scene, const SimulationState& state, const StepReport* report,
                                      const Diagnostics& d, const EnergyAccount& energies, const ContactForces& contact,
                                      const Measurements& measured, const HaloTraffic& halo, int n_ranks,
                                      double seconds_per_step) {
  const StepBounds& b = state.bounds;
  std::vector<HistoryValue> row{state.step, state.time};
  row.emplace_back(report ? report->plan.dt : 0.0);
  row.emplace_back(std::string(report ? name(report->plan.limiter) : "start"));
  row.emplace_back(report ? report->plan.id : GlobalIndex{-1});
  for (const GlobalIndex n : {state.controller.n_trials, state.controller.n_accepted, state.controller.n_rejected,
                              state.controller.n_unchecked_large})
    row.emplace_back(n);
  row.emplace_back(d.mass);
  auto add = [&](const Vec3& v) {
    for (int a = 0; a < 3; ++a) row.emplace_back(v[a]);
  };
  add(d.momentum);
  add(d.angular_momentum);
  for (const double energy :
       {d.kinetic_energy, d.elastic_energy, d.gravitational_energy, d.dissipated_energy + energies.removed_dissipation})
    row.emplace_back(energy);
  add_energies(scene, energies, row);
  add(d.center_of_mass);
  add(d.lower);
  add(d.upper);
  for (const double value : {b.motion.speed.value, b.motion.velocity_gradient.value, b.motion.wave_speed.value,
                             b.totals.smallest_volume_ratio.value, b.totals.largest_volume_ratio.value, d.volume_error,
                             d.yielded_fraction, measured.thickness_decile})
    row.emplace_back(value);
  row.emplace_back(d.n_particles);
  row.emplace_back(state.n_removed);
  row.emplace_back(particle_imbalance(b, n_ranks));
  for (const GlobalIndex n : {state.n_repartitions, state.n_moved, state.n_migrated, halo.largest, halo.total / n_ranks})
    row.emplace_back(n);
  row.emplace_back(seconds_per_step);
  if (is_implicit(scene)) {
    const PressureFigures pressure = pressure_figures(state.pressure);
    row.emplace_back(pressure.iterations);
    row.emplace_back(pressure.most_iterations);
    row.emplace_back(pressure.contact_rounds);
  }
  if (has_implicit_viscosity(scene)) {
    const ViscosityFigures viscosity = viscosity_figures(state.viscosity);
    row.emplace_back(viscosity.iterations);
    row.emplace_back(viscosity.most_iterations);
  }
  for (const double value : measured.forces) row.emplace_back(value);
  const double per_second = contact.duration > 0.0 ? 1.0 / contact.duration : 0.0;
  const std::size_t n_gauges = measured.gauge_areas.size(), n_colliders = scene.colliders.size();
  const std::size_t n_inflows = scene.inflows.size(), first_gauge = n_colliders + n_inflows;
  for (std::size_t c = 0; c < n_colliders; ++c) {
    add(per_second * contact.impulses.impulse(c));
    add(per_second * contact.impulses.angular_impulse(c));
    row.emplace_back(energies.contact_loss[n_faces + c]);
    row.emplace_back(energies.contact_work[n_faces + c]);
  }
  for (std::size_t body = 0; body < measured.bodies.size(); ++body) {
    for (const double value : measured.bodies[body]) row.emplace_back(value);
    row.emplace_back(energies.contact_loss[n_faces + n_colliders + n_inflows + body]);
    row.emplace_back(energies.contact_work[n_faces + n_colliders + n_inflows + body]);
  }
  for (const double reach : measured.reaches) row.emplace_back(reach);
  for (std::size_t g = 0; g < n_gauges; ++g) {
    add(per_second * contact.impulses.impulse(first_gauge + g));
    row.emplace_back(per_second * contact.impulses.impulse(first_gauge + n_gauges + g)[0] / measured.gauge_areas[g]);
  }
  for (std::size_t i = 0; i < n_inflows; ++i) {
    for (const double value : {measured.fed[i].mass, measured.fed[i].particle_mass}) row.emplace_back(value);
    for (const GlobalIndex n : {measured.fed[i].n_entered, measured.fed[i].n_in_feed, measured.fed[i].n_pushed_back})
      row.emplace_back(n);
    row.emplace_back(measured.fed[i].pressure);
    add(per_second * contact.impulses.impulse(n_colliders + i));
    add(per_second * contact.impulses.angular_impulse(n_colliders + i));
    add(per_second * contact.impulses.impulse(first_gauge + 2 * n_gauges + i));
    row.emplace_back(energies.fed[i]);
    row.emplace_back(energies.contact_loss[n_faces + n_colliders + i]);
    row.emplace_back(energies.contact_work[n_faces + n_colliders + i]);
  }
  return row;
}

std::vector<FedFigures> fed_figures(const Scene& scene, const Solver& solver, double time) {
  std::vector<FedFigures> figures;
  const std::vector<GlobalIndex> pushed_back = solver.pushed_back();
  for (std::size_t f = 0; f < pushed_back.size(); ++f) {
    const Feed& feed = solver.physics().feeds[f];
    const Inflow& inflow = feed.inflow();
    const auto law = volumetric_law(scene.materials[inflow.material_index].material);
    const GlobalIndex n_entered = feed.n_particles(feed.released(time));
    figures.push_back({feed.inflow().density * feed.entered_volume(time),
                       feed.inflow().density * feed.particle_volume() * static_cast<double>(n_entered), n_entered,
                       feed.n_particles(feed.born(time)) - n_entered, pushed_back[f],
                       law ? 0.0 - law->stress(inflow.volume_ratio * solver.feed_stretches()[f]) : 0.0});
  }
  return figures;
}

double particle_imbalance(const StepBounds& bounds, int n_ranks) {
  if (bounds.totals.n_particles == 0) return 1.0;
  return static_cast<double>(bounds.transport.largest_share) * n_ranks / static_cast<double>(bounds.totals.n_particles);
}

RunProgress progress_at_start(const Comm& comm, const Scene& scene, const RunOptions& options) {
  RunProgress progress;
  progress.title = scene.title;
  progress.program = options.program;
  if (!options.continuation.empty())
    progress.continuation = fmt::format("mpirun -n {} {}", comm.size(), options.continuation);
  std::array<char, 256> host{};  // ends with a zero: gethostname may not write one
  if (::gethostname(host.data(), host.size() - 1) == 0) progress.host = host.data();
  progress.started = time_stamp();
  progress.n_ranks = comm.size();
  progress.end_time = scene.time_stepping.end_time;
  progress.warnings = scene.warnings;
  if (progress.warnings.size() > most_warnings_kept) progress.warnings.resize(most_warnings_kept);
  return progress;
}

void update_clock(const SimulationState& state, const RunClock& clock, RunProgress& progress) {
  progress.n_particles = state.bounds.totals.n_particles;
  progress.first_step = clock.first_step;
  progress.first_time = clock.first_time;
  progress.elapsed = MPI_Wtime() - clock.start;
  progress.stepping = clock.stepping;
  progress.output = clock.output;
}

void update_progress(const Comm& comm, const SimulationState& state, const RunClock& clock, const PhaseTimes& times,
                     RunProgress& progress) {
  update_clock(state, clock, progress);
  progress.peak_memory = max_global(comm, static_cast<double>(peak_resident_bytes()));
  progress.phases = summarize(comm, times);
}

std::string progress_line(const SimulationState& state, const TimeStepPlan& plan, double end_time, const RunClock& clock,
                          int n_ranks) {
  const double elapsed = MPI_Wtime() - clock.start;
  const double rate = clock.stepping > 0.0 ? clock.particle_steps / clock.stepping * 1e-6 : 0.0;
  const auto steps_done = static_cast<double>(std::max<GlobalIndex>(state.step - clock.first_step, 1));
  const double steps_left = (end_time - state.time) / std::max(plan.dt, 1e-300);
  return fmt::format(
      "step {:>8}  t = {:.5f} / {:g} s  dt = {:.2e} s ({})  {} particles  v_max = {:.3g} m/s  imbalance {:.2f}  "
      "{:.2f} M particle-steps/s  elapsed {}  left {}",
      state.step, state.time, end_time, plan.dt, name(plan.limiter), state.bounds.totals.n_particles.value,
      state.bounds.motion.speed.value, particle_imbalance(state.bounds, n_ranks), rate,
      duration_text(static_cast<double>(static_cast<long>(elapsed))),
      duration_text(static_cast<double>(static_cast<long>(steps_left * elapsed / steps_done))));
}

std::string run_summary(const Comm& comm, const SimulationState& state, const RunClock& clock, const PhaseTimes& times,
                        const BalanceTotals& balance, const HaloTraffic& halo) {
  const std::vector<PhaseSummary> phases = summarize(comm, times);
  const double peak = max_global(comm, static_cast<double>(peak_resident_bytes()));
  // A rank-second is one rank for one second: per particle and step that is what the job pays for.
  auto per_particle = [&](double seconds) {
    return clock.particle_steps > 0.0 ? seconds * comm.size() / clock.particle_steps * 1e9 : 0.0;
  };
  const double total = MPI_Wtime() - clock.start;
  const double mean_imbalance =
      clock.particle_steps > 0.0 ? clock.largest_share_steps * comm.size() / clock.particle_steps : 1.0;
  std::string text = fmt::format(
      "{} steps to t = {:g} s in {} ({} in steps, {} in output); {} trials, {} accepted; {} steps rejected before they were "
      "taken\n",
      state.step - clock.first_step, state.time, duration_text(total), duration_text(clock.stepping),
      duration_text(clock.output), state.controller.n_trials, state.controller.n_accepted, state.controller.n_rejected);
  text += fmt::format(
      "{} particles on {} ranks, imbalance {:.3f} (mean over the steps {:.3f}), {} removed; peak memory {:.0f} MiB on the "
      "largest "
      "rank\n",
      state.bounds.totals.n_particles.value, comm.size(), particle_imbalance(state.bounds, comm.size()), mean_imbalance,
      state.n_removed, peak / (1024.0 * 1024.0));
  if (comm.size() > 1) {
    const double n_particles = std::max(1.0, static_cast<double>(state.bounds.totals.n_particles));
    text += fmt::format(
        "{} new maps of tiles to ranks, {:.1f} % of the particles moved by each, {:.2g} % of the time in steps; {} KiB sent "
        "per step by the busiest rank, {} on average\n",
        balance.n_repartitions,
        100.0 * static_cast<double>(balance.n_moved) /
            (n_particles * static_cast<double>(std::max<GlobalIndex>(balance.n_repartitions, 1))),
        100.0 * balance.seconds / std::max(clock.stepping, 1e-300), halo.largest / 1024, halo.total / comm.size() / 1024);
  }
  text +=
      fmt::format("{:.1f} ns per particle, step and rank (ranks x time / particle-steps):", per_particle(clock.stepping));
  for (const PhaseSummary& phase : phases) text += fmt::format("  {} {:.1f}", phase.name, per_particle(phase.mean));
  return text;
}

}  // namespace bulkley
