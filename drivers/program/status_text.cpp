#include "program/status_text.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>

#include "program/human_text.hpp"

namespace bulkley {

namespace {

std::string percent(double part) { return fmt::format("{:.{}f} %", 100.0 * part, part > 0.0 && part < 0.1 ? 1 : 0); }

// Clock time of this machine's zone, with the day where it is another one.
std::string clock_text(double seconds_ahead) {
  const std::time_t now = std::time(nullptr);
  const std::time_t then = now + static_cast<std::time_t>(seconds_ahead);
  const std::tm today = fmt::localtime(now), day = fmt::localtime(then);
  if (today.tm_yday == day.tm_yday && today.tm_year == day.tm_year) return fmt::format("{:%H:%M}", day);
  return fmt::format("{:%Y-%m-%d %H:%M}", day);
}

bool has_rows(const RunView& view) { return view.figures.n_rows > 0; }

// A path as it was given, joined with a name in it, may be long: people know the folder.
std::string name_of(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

}  // namespace

std::string progress_text(const RunView& view) {
  const RunFigures& f = view.figures;
  if (!std::isfinite(view.run.end_time)) return fmt::format("t = {} s, step {}", number_text(f.time), count_text(f.step));
  return fmt::format("t = {:.4g} of {:.4g} s ({:.1f} %), step {}", f.time, view.run.end_time, 100.0 * f.done(view.run),
                     count_text(f.step));
}

std::string rate_text(const RunView& view) {
  const RunFigures& f = view.figures;
  std::string text;
  if (std::isfinite(f.recent_steps_per_second))
    text = fmt::format("{} steps/s and {} s of the run per hour lately", number_text(f.recent_steps_per_second),
                       number_text(3600.0 * f.recent_time_per_second));
  if (std::isfinite(f.part_steps_per_second))
    text += fmt::format("{}{} steps/s over the {} of this part", text.empty() ? "" : "; ",
                        number_text(f.part_steps_per_second), span_text(view.run.elapsed));
  return text.empty() ? "not known yet" : text;
}

std::string left_text(const RunView& view) {
  const double seconds = view.figures.left(view.run);
  if (!std::isfinite(seconds)) return "not known yet";
  if (view.run.running() && !view.silent()) return fmt::format("{}, until {}", span_text(seconds), clock_text(seconds));
  return fmt::format("{} after it continues", span_text(seconds));
}

std::string limiter_text(const RunView& view) {
  const RunFigures& f = view.figures;
  std::string shares;
  for (const auto& [name, share] : f.limiter_shares)
    shares += fmt::format("{}{} {}", shares.empty() ? "" : ", ", name, percent(share));
  if (shares.empty()) return "not known yet";
  return fmt::format("{:.3g} s; limited by {} ({} {})", f.dt, shares, f.all_rows ? "of" : "of the last",
                     counted(static_cast<double>(f.n_rows), "row"));
}

std::string trials_text(const RunView& view) {
  const RunFigures& f = view.figures;
  if (!has_rows(view)) return "not known yet";
  return fmt::format("{} of a larger step, {} accepted; {} rejected", counted(f.trials, "trial"), count_text(f.accepted),
                     counted(f.rejected, "step"));
}

std::string volume_text(const RunView& view) {
  const RunFigures& f = view.figures;
  if (!std::isfinite(f.volume_error)) return {};
  std::string text;
  if (std::isfinite(f.pressure_iterations))
    text = fmt::format("implicit pressure: {:.1f} iterations a step (at most {:.0f}), ", f.pressure_iterations,
                       f.most_pressure_iterations);
  if (std::isfinite(f.viscosity_iterations))
    text += fmt::format("viscosity {:.1f} (at most {:.0f}), ", f.viscosity_iterations, f.most_viscosity_iterations);
  return text + fmt::format("volume error {:.2g}", f.volume_error);
}

std::string particles_text(const RunView& view) {
  const RunFigures& f = view.figures;
  const double n = has_rows(view) ? f.particles : view.run.n_particles;
  std::string text = fmt::format("{}", count_text(n));
  if (view.run.n_ranks > 0.0) text += fmt::format(" on {}", counted(view.run.n_ranks, "rank"));
  if (std::isfinite(f.imbalance)) text += fmt::format(", imbalance {:.2f}", f.imbalance);
  if (std::isfinite(f.mass)) text += fmt::format("; mass {:.4g} kg", f.mass);
  if (f.removed > 0.0) text += fmt::format("; {} left through outflow faces", count_text(f.removed));
  return text;
}

std::string energy_text(const RunView& view) {
  const EnergyFigures& e = view.figures.last;
  if (!has_rows(view)) return "not known yet";
  const double fallen = e.gravitational - view.figures.first.gravitational;
  return fmt::format("kinetic {} J, elastic {} J, gravity {}{} J since the start, dissipated by the laws {} J",
                     number_text(e.kinetic), number_text(e.elastic), fallen > 0.0 ? "+" : "", number_text(fallen),
                     number_text(e.dissipated));
}

std::string balance_text(const RunView& view) {
  const RunFigures& f = view.figures;
  const double change = f.last.sum() - f.first.sum();
  if (!std::isfinite(change)) return "not known yet";
  std::string text = fmt::format("{} J {} these four since the start", number_text(std::abs(change)),
                                 change > 0.0 ? "came into" : "went out of");
  if (f.energy_scale > 0.0)
    text += fmt::format(", {} of {} J", percent(std::abs(change) / f.energy_scale), number_text(f.energy_scale));
  return text;
}

namespace {

// A term in J and as a part of the energy that was there to be lost.
std::string term_text(const std::string& name, double value, double whole) {
  const std::string part =
      whole > 0.0 ? fmt::format(" ({}{})", value < 0.0 ? "-" : "", percent(std::abs(value) / whole)) : "";
  return fmt::format("{} {} J{}", name, number_text(value), part);
}

bool counts(double value) { return std::isfinite(value) && value != 0.0; }

// Of what was received: contacts that lost less are told together.
constexpr double least_share = 1e-3;

// What there was at the start of the table, and what came in since, J.
double energy_received(const RunFigures& f) {
  double sum = f.first.kinetic + f.first.elastic;
  for (const double work : {f.account.gravity, f.account.acceleration_field, f.account.magnetic_field})
    if (work > 0.0) sum += work;
  for (const auto& [name, work] : f.account.contact_works) sum += std::max(work, 0.0);
  return sum;
}

}  // namespace

std::string received_text(const RunView& view) {
  const RunFigures& f = view.figures;
  if (!f.account.known()) return {};
  std::string text = fmt::format("{} J at the start", number_text(f.first.kinetic + f.first.elastic));
  const auto add = [&](const std::string& name, double work) {
    if (counts(work)) text += fmt::format(", {} {} J", name, number_text(work));
  };
  add("gravity", f.account.gravity);
  add("acceleration_field", f.account.acceleration_field);
  add("magnetic_field", f.account.magnetic_field);
  for (const auto& [name, work] : f.account.contact_works) add("motion of " + name, work);
  return text;
}

std::string losses_text(const RunView& view) {
  const RunFigures& f = view.figures;
  const AccountFigures& a = f.account;
  if (!a.known()) return {};
  const double whole = energy_received(f);
  std::string text = term_text("laws", f.last.dissipated - f.first.dissipated, whole);
  const auto add = [&](const std::string& name, double loss) {
    if (counts(loss)) text += ", " + term_text(name, loss, whole);
  };
  double others = 0.0;
  for (const auto& [name, loss] : a.contact_losses)
    if (std::abs(loss) < least_share * whole)
      others += loss;
    else
      add("contact " + name, loss);
  add("other contacts", others);
  if (std::isfinite(a.to_grid)) {
    text += fmt::format(", {}: {} to the grid, {} from it", term_text("transfers", a.to_grid + a.from_grid, whole),
                        number_text(a.to_grid), number_text(a.from_grid));
    add("time integration", a.time_integration);
  } else {
    text += fmt::format(", {}: {} from the grid",
                        term_text("transfers and time integration", a.to_grid_and_integration + a.from_grid, whole),
                        number_text(a.from_grid));
  }
  add("removed particles", a.removed);
  add("still kinetic", f.last.kinetic);
  add("elastic", f.last.elastic);
  return text;
}

std::string closure_text(const RunView& view) {
  const double whole = energy_received(view.figures);
  if (!view.figures.account.known()) return {};
  return fmt::format("the sum of all is {:.1g} J{}", view.figures.account.residual,
                     whole > 0.0 ? fmt::format(", {:.0g} of what came in", std::abs(view.figures.account.residual) / whole)
                                 : std::string());
}

std::string disk_text(const RunView& view) {
  const DiskUse& d = view.run.disk;
  return fmt::format("{}: {} {}, {} {}, rest {}", bytes_text(d.total()),
                     counted(static_cast<double>(view.run.checkpoints.size()), "checkpoint"), bytes_text(d.checkpoints),
                     counted(static_cast<double>(d.n_frames), "frame"), bytes_text(d.frames), bytes_text(d.rest));
}

std::string checkpoint_text(const RunView& view) {
  const RunFolder& run = view.run;
  if (run.checkpoints.empty()) return "none yet";
  const CheckpointFile& last = run.checkpoints.back();
  std::string time;
  if (name_of(run.last_checkpoint) == name_of(last.path) && std::isfinite(run.last_checkpoint_time))
    time = fmt::format(", t = {:.4g} s", run.last_checkpoint_time);
  return fmt::format("step {}{}, {} ago: {}", count_text(static_cast<double>(last.step)), time,
                     span_text(std::max(last.age, 0.0)), last.path);
}

std::string advice_text(const RunView& view) {
  const RunFolder& run = view.run;
  const bool can_go_on = !run.checkpoints.empty() && !run.continuation.empty();
  if (view.silent())
    return fmt::format(
        "nothing has been written for {}: it hangs, or was killed{}{}", span_text(run.age),
        run.host.empty() ? "" : " on " + run.host,
        can_go_on ? "; if it was, continue with: " + run.continuation : "; there is no checkpoint to continue from");
  if (run.state == "failed" && can_go_on) return "from the last checkpoint, once that is fixed: " + run.continuation;
  if (run.state == "stopped" && run.reason.find("continue with: ") == std::string::npos && can_go_on)
    return "continue with: " + run.continuation;
  return {};
}

std::string status_lines(const RunView& view) {
  const RunFolder& run = view.run;
  std::string text = fmt::format("{}: {} ({})\n", run.title.empty() ? "run" : run.title, view.state(), run.path);
  const auto add = [&](const char* name, const std::string& value) { text += fmt::format("  {:<11} {}\n", name, value); };
  add("progress", progress_text(view));
  add("rate", rate_text(view));
  if (run.state != "finished") add("left", left_text(view));
  add("time step", limiter_text(view));
  add("trials", trials_text(view));
  if (const std::string volume = volume_text(view); !volume.empty()) add("volume", volume);
  add("particles", particles_text(view));
  if (std::isfinite(view.figures.thickness_decile))
    add("thickness",
        fmt::format("{} cells in the thinnest tenth of the material", number_text(view.figures.thickness_decile)));
  add("energy", energy_text(view));
  if (view.figures.account.known()) {
    add("received", received_text(view));
    add("went to", losses_text(view));
    add("closure", closure_text(view));
  } else {
    add("balance", balance_text(view));
  }
  add("disk", disk_text(view));
  add("checkpoint", checkpoint_text(view));
  add("last update", fmt::format("{} ago{}", span_text(run.age), run.host.empty() ? "" : ", from " + run.host));
  for (const std::string& warning : run.warnings) add("warning", warning);
  if (!run.reason.empty()) add("reason", run.reason);
  if (const std::string advice = advice_text(view); !advice.empty()) add("note", advice);
  return text;
}

std::string status_line(const RunView& view) {
  const RunFigures& f = view.figures;
  return fmt::format("{}: {}, {}, dt = {} s ({}), {} steps/s, left {}", view.run.path, view.state(), progress_text(view),
                     number_text(f.dt), f.limiter.empty() ? "-" : f.limiter, number_text(f.recent_steps_per_second),
                     span_text(f.left(view.run)));
}

std::string status_table(const std::vector<RunView>& views) {
  std::size_t width = 6;
  for (const RunView& view : views) width = std::max(width, view.run.path.size());
  std::string text = fmt::format("{:<{}}  {:<9}{:>7}{:>10}{:>10}{:>10}{:>13}{:>11}{:>10}{:>11}\n", "folder", width, "state",
                                 "done", "step", "steps/s", "left", "limiter", "particles", "imbalance", "disk");
  for (const RunView& view : views) {
    const RunFigures& f = view.figures;
    const double done = f.done(view.run);
    text += fmt::format(
        "{:<{}}  {:<9}{:>7}{:>10.0f}{:>10}{:>10}{:>13}{:>11.0f}{:>10.2f}{:>11}\n", view.run.path, width, view.state(),
        std::isfinite(done) ? fmt::format("{:.1f} %", 100.0 * done) : "?", f.step, number_text(f.recent_steps_per_second),
        view.run.state == "finished" ? "-" : span_text(f.left(view.run)), f.limiter.empty() ? "-" : f.limiter,
        std::isfinite(f.particles) ? f.particles : view.run.n_particles, f.imbalance, bytes_text(view.run.disk.total()));
  }
  return text;
}

Json account_json(const AccountFigures& a) {
  Json losses = Json::object(), works = Json::object();
  for (const auto& [name, loss] : a.contact_losses) losses[name] = rounded(loss);
  for (const auto& [name, work] : a.contact_works) works[name] = rounded(work);
  return {{"gravity_work", rounded(a.gravity)},
          {"acceleration_field_work", rounded(a.acceleration_field)},
          {"magnetic_field_work", rounded(a.magnetic_field)},
          {"to_grid_loss", rounded(a.to_grid)},
          {"time_integration_loss", rounded(a.time_integration)},
          {"to_grid_and_integration_loss", rounded(a.to_grid_and_integration)},
          {"from_grid_loss", rounded(a.from_grid)},
          {"removed_energy", rounded(a.removed)},
          {"residual", rounded(a.residual)},
          {"contact_losses", losses},
          {"contact_works", works}};
}

Json status_json(const RunView& view) {
  const RunFolder& run = view.run;
  const RunFigures& f = view.figures;
  const DiskUse& d = run.disk;
  const auto whole = [](double value) { return std::isfinite(value) ? static_cast<GlobalIndex>(value) : GlobalIndex{-1}; };
  Json shares = Json::object();
  for (const auto& [name, share] : f.limiter_shares) shares[name] = rounded(share);
  return {{"folder", run.path},
          {"title", run.title},
          {"state", view.state()},
          {"reason", run.reason},
          {"step", whole(f.step)},
          {"time", rounded(f.time)},
          {"end_time", rounded(run.end_time)},
          {"done", rounded(f.done(run))},
          {"seconds_left", rounded(f.left(run))},
          {"steps_per_second", rounded(f.recent_steps_per_second)},
          {"time_per_second", rounded(f.recent_time_per_second)},
          {"part_steps_per_second", rounded(f.part_steps_per_second)},
          {"part_time_per_second", rounded(f.part_time_per_second)},
          {"dt", rounded(f.dt)},
          {"limiter", f.limiter},
          {"limiter_shares", shares},
          {"rows", f.n_rows},
          {"trials", whole(f.trials)},
          {"accepted_trials", whole(f.accepted)},
          {"rejected_steps", whole(f.rejected)},
          {"ranks", whole(run.n_ranks)},
          {"particles", whole(f.particles)},
          {"removed_particles", whole(f.removed)},
          {"imbalance", rounded(f.imbalance)},
          {"mass", rounded(f.mass)},
          {"max_speed", rounded(f.max_speed)},
          {"thickness_decile", rounded(f.thickness_decile)},
          {"volume_error", rounded(f.volume_error)},
          {"pressure_iterations", rounded(f.pressure_iterations)},
          {"pressure_iterations_max", whole(f.most_pressure_iterations)},
          {"contact_rounds", rounded(f.contact_rounds)},
          {"viscosity_iterations", rounded(f.viscosity_iterations)},
          {"viscosity_iterations_max", whole(f.most_viscosity_iterations)},
          {"kinetic_energy", rounded(f.last.kinetic)},
          {"elastic_energy", rounded(f.last.elastic)},
          {"gravitational_energy", rounded(f.last.gravitational)},
          {"dissipated_energy", rounded(f.last.dissipated)},
          {"energy_change", rounded(f.last.sum() - f.first.sum())},
          {"energy_scale", rounded(f.energy_scale)},
          {"energy_account", account_json(f.account)},
          {"disk",
           {{"checkpoints", whole(d.checkpoints)},
            {"frames", whole(d.frames)},
            {"rest", whole(d.rest)},
            {"total", whole(d.total())}}},
          {"frames", d.n_frames},
          {"checkpoint", run.checkpoints.empty() ? "" : run.checkpoints.back().path},
          {"checkpoint_step", run.checkpoints.empty() ? GlobalIndex{-1} : run.checkpoints.back().step},
          {"seconds_since_sign", rounded(run.age)},
          {"longest_silence", rounded(run.longest_silence)},
          {"host", run.host},
          {"continuation", run.continuation}};
}

}  // namespace bulkley
