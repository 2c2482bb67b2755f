#include "program/run_figures.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>

#include "program/history_reader.hpp"

namespace bulkley {

namespace {

constexpr std::size_t bytes_looked_at = 4'000'000;
constexpr std::size_t n_recent_rows = 100;

struct Pace {
  double step, time, seconds;  // seconds: of wall time per step since the row before
};

struct EnergyColumns {
  explicit EnergyColumns(const HistoryReader& reader)
      : kinetic(reader.find("kinetic_energy [J]")),
        elastic(reader.find("elastic_energy [J]")),
        gravitational(reader.find("gravitational_energy [J]")),
        dissipated(reader.find("dissipated_energy [J]")) {}
  EnergyFigures of(const HistoryReader& reader) const {
    return {reader.number(kinetic), reader.number(elastic), reader.number(gravitational), reader.number(dissipated)};
  }
  int kinetic, elastic, gravitational, dissipated;
};

struct AccountColumns {
  explicit AccountColumns(const HistoryReader& reader) {
    for (const std::string& column : reader.columns()) {
      if (const auto end = column.find(".contact_loss [J]"); end != std::string::npos)
        losses.emplace_back(column.substr(0, end), reader.find(column));
      if (const auto end = column.find(".contact_work [J]"); end != std::string::npos)
        works.emplace_back(column.substr(0, end), reader.find(column));
    }
  }
  AccountFigures of(const HistoryReader& reader) const {
    const auto value = [&](const char* column) { return reader.number(reader.find(column)); };
    AccountFigures account{value("gravity_work [J]"),
                           value("acceleration_field_work [J]"),
                           value("magnetic_field_work [J]"),
                           value("to_grid_loss [J]"),
                           value("time_integration_loss [J]"),
                           value("to_grid_and_integration_loss [J]"),
                           value("from_grid_loss [J]"),
                           value("removed_energy [J]"),
                           value("energy_residual [J]"),
                           {},
                           {}};
    for (const auto& [name, column] : losses) account.contact_losses.emplace_back(name, reader.number(column));
    for (const auto& [name, column] : works) account.contact_works.emplace_back(name, reader.number(column));
    return account;
  }
  std::vector<std::pair<std::string, int>> losses, works;
};

// The largest of the energies that can have changed into each other; where gravity's begins is arbitrary.
double scale_of(const EnergyFigures& first, const EnergyFigures& now) {
  return std::max({first.kinetic + first.elastic, now.kinetic + now.elastic, now.dissipated - first.dissipated,
                   std::abs(now.gravitational - first.gravitational)});
}

void take_last_row(const HistoryReader& reader, RunFigures& figures) {
  const auto value = [&](const char* column) { return reader.number(reader.find(column)); };
  figures.last_row_time = value("time [s]");
  figures.dt = value("dt [s]");
  figures.limiter = reader.text(reader.find("limiter"));
  figures.trials = value("trials");
  figures.accepted = value("accepted_trials");
  figures.rejected = value("rejected_steps");
  figures.particles = value("particles");
  figures.removed = value("removed_particles");
  figures.imbalance = value("imbalance");
  figures.mass = value("mass [kg]");
  figures.max_speed = value("max_speed [m/s]");
  figures.thickness_decile = value("thickness_decile [cells]");
  figures.volume_error = value("volume_error");
  figures.pressure_iterations = value("pressure_iterations");
  figures.most_pressure_iterations = value("pressure_iterations_max");
  figures.contact_rounds = value("contact_rounds");
  figures.viscosity_iterations = value("viscosity_iterations");
  figures.most_viscosity_iterations = value("viscosity_iterations_max");
  const double step = value("step");
  if (!(figures.step >= step)) {
    figures.step = step;
    figures.time = figures.last_row_time;
  }
}

void take_pace(const RunFolder& run, const std::deque<Pace>& rows, RunFigures& figures) {
  double seconds = 0.0;
  for (std::size_t k = 1; k < rows.size(); ++k) seconds += (rows[k].step - rows[k - 1].step) * rows[k].seconds;
  if (seconds > 0.0) {
    const double steps = rows.back().step - rows.front().step;
    figures.seconds_per_step = seconds / steps;
    const double with_output = run.stepping > 0.0 ? (run.stepping + run.output) / run.stepping : 1.0;
    figures.recent_steps_per_second = steps / (seconds * with_output);
    figures.recent_time_per_second = (rows.back().time - rows.front().time) / (seconds * with_output);
  }
  if (run.elapsed > 0.0 && run.step > run.first_step) {
    figures.part_steps_per_second = (run.step - run.first_step) / run.elapsed;
    figures.part_time_per_second = (run.time - run.first_time) / run.elapsed;
  }
}

}  // namespace

double RunFigures::done(const RunFolder& run) const {
  return run.end_time > 0.0 ? std::clamp(time / run.end_time, 0.0, 1.0) : unknown;
}

double RunFigures::left(const RunFolder& run) const {
  const double rate = recent_time_per_second > 0.0 ? recent_time_per_second : part_time_per_second;
  return rate > 0.0 ? std::max(run.end_time - time, 0.0) / rate : unknown;
}

RunFigures figures_of(const RunFolder& run) {
  RunFigures figures{};
  for (double* value : {&figures.dt,
                        &figures.last_row_time,
                        &figures.trials,
                        &figures.accepted,
                        &figures.rejected,
                        &figures.particles,
                        &figures.removed,
                        &figures.imbalance,
                        &figures.mass,
                        &figures.max_speed,
                        &figures.thickness_decile,
                        &figures.volume_error,
                        &figures.pressure_iterations,
                        &figures.most_pressure_iterations,
                        &figures.contact_rounds,
                        &figures.viscosity_iterations,
                        &figures.most_viscosity_iterations,
                        &figures.energy_scale,
                        &figures.seconds_per_step,
                        &figures.recent_steps_per_second,
                        &figures.recent_time_per_second,
                        &figures.part_steps_per_second,
                        &figures.part_time_per_second})
    *value = unknown;
  figures.first = figures.last = {unknown, unknown, unknown, unknown};
  figures.account = {unknown, unknown, unknown, unknown, unknown, unknown, unknown, unknown, unknown, {}, {}};
  figures.step = run.step;
  figures.time = run.time;

  HistoryReader reader(run.path);
  const EnergyColumns energies(reader);
  const AccountColumns account(reader);
  const int step = reader.find("step"), time = reader.find("time [s]"), limiter = reader.find("limiter"),
            seconds = reader.find("wall_time_per_step [s]");
  std::map<std::string, double, std::less<>> counts;
  std::deque<Pace> recent;
  double n_limited = 0.0;
  const auto take = [&] {
    ++figures.n_rows;
    if (reader.text(limiter) != "start" && limiter >= 0) {
      ++counts[std::string(reader.text(limiter))];
      ++n_limited;
    }
    recent.push_back({reader.number(step), reader.number(time), reader.number(seconds)});
    if (recent.size() > n_recent_rows + 1) recent.pop_front();
    take_last_row(reader, figures);
    figures.last = energies.of(reader);
    figures.account = account.of(reader);
  };
  if (reader.next()) {
    figures.first = energies.of(reader);
    take();
    if (reader.skip_to_last(bytes_looked_at)) {
      figures.all_rows = false;
      figures.n_rows = 0;
      counts.clear();
      n_limited = 0.0;
      recent.clear();
    }
    while (reader.next()) take();
    figures.energy_scale = scale_of(figures.first, figures.last);
  }
  take_pace(run, recent, figures);
  for (const auto& [name, count] : counts) figures.limiter_shares.emplace_back(name, count / n_limited);
  std::stable_sort(figures.limiter_shares.begin(), figures.limiter_shares.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return figures;
}

}  // namespace bulkley
