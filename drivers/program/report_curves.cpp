#include "program/report_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "program/history_reader.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

namespace {

constexpr std::size_t n_bins = 500, most_points = 1000;
constexpr const char* time_name = "time [s]";

// One curve of a plot: the sum of columns, less that of the first row if it is a change.
struct Source {
  std::string name;
  std::vector<int> columns;
  bool is_change;
  ThinnedCurve curve;
  double start = 0.0;
};

struct Sheet {
  Plot plot;
  std::vector<Source> sources;
};

class Sheets {
 public:
  Sheets(const HistoryReader& reader, double lower, double upper) : reader_(reader), lower_(lower), upper_(upper) {}

  Plot& begin(const char* title, const char* unit) {
    Plot plot;
    plot.title = title;
    plot.x_name = time_name;
    plot.y_name = unit;
    sheets_.push_back({std::move(plot), {}});
    return sheets_.back().plot;
  }
  void curve(const std::string& name, const std::vector<std::string>& columns, bool is_change = false) {
    std::vector<int> indices;
    for (const std::string& column : columns) indices.push_back(reader_.find(column));
    sheets_.back().sources.push_back({name, indices, is_change, ThinnedCurve(lower_, upper_)});
  }
  void vector(const std::string& name, const std::string& unit) {
    for (const char* axis : {"x", "y", "z"}) curve(axis, {fmt::format("{}_{} {}", name, axis, unit)});
  }

  void take_row(double time, bool is_first) {
    for (Sheet& sheet : sheets_)
      for (Source& source : sheet.sources) {
        double value = 0.0;
        for (const int column : source.columns) value += reader_.number(column);
        if (is_first && source.is_change) source.start = value;
        if (is_first && sheet.plot.skips_first) continue;
        source.curve.add(time, value - source.start);
      }
  }

  std::vector<Plot> plots() {
    std::vector<Plot> plots;
    for (Sheet& sheet : sheets_) {
      int colour = 0;
      for (Source& source : sheet.sources) sheet.plot.curves.push_back({source.name, colour++, source.curve.points()});
      plots.push_back(std::move(sheet.plot));
    }
    return plots;
  }

 private:
  const HistoryReader& reader_;
  double lower_, upper_;
  std::vector<Sheet> sheets_;
};

void lay_out(Sheets& sheets, const HistoryReader& reader) {
  sheets.begin("Energies", "[J]");
  sheets.curve("kinetic", {"kinetic_energy [J]"});
  sheets.curve("elastic", {"elastic_energy [J]"});
  sheets.curve("gravity, change", {"gravitational_energy [J]"}, true);
  sheets.curve("plastic dissipation", {"dissipated_energy [J]"});
  sheets.begin("Energy balance: change of the sum of these four", "[J]").from_zero = true;
  sheets.curve("change of the sum",
               {"kinetic_energy [J]", "elastic_energy [J]", "gravitational_energy [J]", "dissipated_energy [J]"}, true);
  sheets.begin("Momentum", "[kg m/s]");
  sheets.vector("momentum", "[kg m/s]");
  sheets.begin("Angular momentum about the origin", "[kg m\u00b2/s]");
  sheets.vector("angular_momentum", "[kg m^2/s]");
  sheets.begin("Centre of mass", "[m]");
  sheets.vector("center_of_mass", "[m]");
  sheets.begin("Largest speed", "[m/s]").from_zero = true;
  sheets.curve("largest speed", {"max_speed [m/s]"});
  sheets.begin("Volume ratio, smallest and largest", "");
  sheets.curve("smallest", {"min_volume_ratio"});
  sheets.curve("largest", {"max_volume_ratio"});
  sheets.begin("Yielded part of the mass", "").from_zero = true;
  sheets.curve("yielded", {"yielded_fraction"});
  sheets.begin("Imbalance: largest over mean particles of a rank", "");
  sheets.curve("imbalance", {"imbalance"});
  Plot& wall_time = sheets.begin("Wall time of a step", "[s]");
  wall_time.may_be_log = wall_time.skips_first = true;  // the first row stands before the first step
  sheets.curve("wall time", {"wall_time_per_step [s]"});
  sheets.begin("Rejected steps so far", "").from_zero = true;
  sheets.curve("rejected", {"rejected_steps"});
  if (reader.columns().empty()) return;
  constexpr std::string_view mark = ".force_x [N]", turn = ".torque_x [N m]";
  for (const std::string& column : reader.columns()) {
    if (column.ends_with(mark)) {
      const std::string collider = column.substr(0, column.size() - mark.size());
      sheets.begin(("Force on " + collider).c_str(), "[N]");
      sheets.vector(collider + ".force", "[N]");
    } else if (column.ends_with(turn)) {
      const std::string collider = column.substr(0, column.size() - turn.size());
      sheets.begin(("Torque on " + collider).c_str(), "[N m]");
      sheets.vector(collider + ".torque", "[N m]");
    }
  }
}

// Colours of limiters stay the same from run to run.
int colour_of(std::string_view limiter) {
  for (int k = 0; k <= static_cast<int>(Limiter::output); ++k)
    if (limiter == name(static_cast<Limiter>(k))) return k;
  return 0;
}

// Time steps, one curve a limiter.
class Limited {
 public:
  Limited(double lower, double upper) : lower_(lower), upper_(upper) {}
  void take(double time, double dt, std::string_view limiter) {
    if (limiter == "start" || limiter.empty()) return;
    auto found = curves_.find(limiter);
    if (found == curves_.end()) found = curves_.emplace(limiter, Entry{ThinnedCurve(lower_, upper_), 0.0}).first;
    found->second.curve.add(time, dt);
    ++found->second.count;
    ++n_;
  }
  Plot plot() const {
    Plot plot;
    plot.title = "Time step and what limits it";
    plot.x_name = time_name;
    plot.y_name = "[s]";
    plot.may_be_log = plot.dots = true;
    for (const auto& [name, entry] : curves_) plot.curves.push_back({name, colour_of(name), entry.curve.points()});
    return plot;
  }
  std::vector<PlotBar> shares() const {
    std::vector<PlotBar> bars;
    for (const auto& [name, entry] : curves_) bars.push_back({name, 100.0 * entry.count / n_, 0.0});
    std::stable_sort(bars.begin(), bars.end(), [](const PlotBar& a, const PlotBar& b) { return a.value > b.value; });
    return bars;
  }

 private:
  struct Entry {
    ThinnedCurve curve;
    double count = 0.0;
  };
  double lower_, upper_, n_ = 0.0;
  std::map<std::string, Entry, std::less<>> curves_;
};

}  // namespace

void ThinnedCurve::add(double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y)) return;
  if (!binned_ && first_.size() < most_points) {
    first_.push_back({x, y});
    return;
  }
  if (!binned_) {
    binned_ = true;
    bins_.resize(n_bins);
    const std::vector<PlotPoint> points = std::move(first_);
    for (const PlotPoint& p : points) add(p.x, p.y);
  }
  const double part = upper_ > lower_ ? (x - lower_) / (upper_ - lower_) : 0.0;
  Bin& bin = bins_[std::min(static_cast<std::size_t>(std::clamp(part, 0.0, 1.0) * n_bins), n_bins - 1)];
  if (!bin.used || y < bin.smallest.y) bin.smallest = {x, y};
  if (!bin.used || y > bin.largest.y) bin.largest = {x, y};
  bin.used = true;
}

std::vector<PlotPoint> ThinnedCurve::points() const {
  if (!binned_) return first_;
  std::vector<PlotPoint> points;
  for (const Bin& bin : bins_) {
    if (!bin.used) continue;
    const bool rises = bin.smallest.x <= bin.largest.x;
    points.push_back(rises ? bin.smallest : bin.largest);
    if (bin.smallest.x != bin.largest.x) points.push_back(rises ? bin.largest : bin.smallest);
  }
  return points;
}

HistoryPlots history_plots(const RunFolder& run, double last_time) {
  HistoryReader reader(run.path);
  Sheets sheets(reader, 0.0, last_time);
  lay_out(sheets, reader);
  Limited steps(0.0, last_time);
  const int time = reader.find(time_name), dt = reader.find("dt [s]"), limiter = reader.find("limiter");
  HistoryPlots result;
  while (reader.next()) {
    const double t = reader.number(time);
    if (t > last_time) break;
    sheets.take_row(t, result.n_rows == 0);
    steps.take(t, reader.number(dt), reader.text(limiter));
    ++result.n_rows;
  }
  result.plots = sheets.plots();
  result.plots.insert(result.plots.begin() + std::min<std::ptrdiff_t>(2, std::ssize(result.plots)), steps.plot());
  result.limiters = steps.shares();
  return result;
}

}  // namespace bulkley
