#include "program/partition_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "balance/bisection.hpp"
#include "balance/partition.hpp"
#include "balance/traffic.hpp"
#include "scene/partition_keys.hpp"

namespace bulkley {

namespace {

constexpr double short_seconds = 0.2;  // what takes less is timed three times

std::string name_of(PartitionMethod method) {
  for (const auto& [name, value] : names(config::Of<PartitionMethod>{}))
    if (value == method) return name;
  return {};
}

/// Seconds that `work` takes; the median of three for short work.
template <class Work>
double time_of(const Work& work) {
  std::vector<double> seconds;
  do {
    const auto start = std::chrono::steady_clock::now();
    work();
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  } while (seconds.front() < short_seconds && seconds.size() < 3);
  std::sort(seconds.begin(), seconds.end());
  return seconds[seconds.size() / 2];
}

template <class Value>
double mean_of(const std::vector<RankTraffic>& traffic, const Value& value) {
  double sum = 0.0;
  for (const RankTraffic& rank : traffic) sum += static_cast<double>(value(rank));
  return sum / static_cast<double>(traffic.size());
}

template <class Value>
double largest_of(const std::vector<RankTraffic>& traffic, const Value& value) {
  double largest = 0.0;
  for (const RankTraffic& rank : traffic) largest = std::max(largest, static_cast<double>(value(rank)));
  return largest;
}

void describe(const PartitionTask& task, const Partition& partition, PartitionRow& row) {
  const std::vector<RankTraffic> traffic = predict_traffic(task.grid, partition.map, task.load, task.ranks_per_node);
  const auto uneven = [&](const auto& value) {
    const double mean = mean_of(traffic, value);
    return mean > 0.0 ? largest_of(traffic, value) / mean : 1.0;
  };
  const int n = task.cost.n_exchanges;
  const auto bytes = [n](const RankTraffic& rank) { return n * (rank.bytes_add + rank.bytes_get); };
  const auto messages = [n](const RankTraffic& rank) { return n * (rank.messages_add + rank.messages_get); };
  const auto neighbours = [](const RankTraffic& rank) { return rank.n_neighbours; };
  row.load = uneven([](const RankTraffic& rank) { return rank.load; });
  row.particles = uneven([](const RankTraffic& rank) { return rank.n_particles; });
  row.halo = mean_of(traffic, [](const RankTraffic& rank) { return rank.n_halo_nodes; }) /
             mean_of(traffic, [](const RankTraffic& rank) { return rank.n_worked_nodes; });
  row.neighbours_mean = mean_of(traffic, neighbours), row.neighbours_max = largest_of(traffic, neighbours);
  row.bytes_mean = mean_of(traffic, bytes), row.bytes_max = largest_of(traffic, bytes);
  if (task.ranks_per_node > 0)
    row.off_node = row.bytes_mean > 0.0
                       ? n * mean_of(traffic, [](const RankTraffic& rank) { return rank.bytes_off_node; }) / row.bytes_mean
                       : 0.0;
  row.messages_mean = mean_of(traffic, messages), row.messages_max = largest_of(traffic, messages);
  row.step_seconds = predicted_step(traffic, task.cost);
}

double moved_part(const PartitionTask& task, const Partition& from, const Partition& to) {
  return static_cast<double>(n_moved(from.map, to.map, task.load)) / static_cast<double>(task.n_particles);
}

/// The rows of one method.
std::vector<PartitionRow> rows_of(const PartitionTask& task, PartitionMethod method, int n_ranks) {
  PartitionSettings settings;
  settings.method = method;
  settings.ranks_per_node = task.ranks_per_node;
  PartitionRow row;
  row.n_ranks = n_ranks;
  row.method = name_of(method);
  try {
    std::optional<Partition> present;
    if (task.before) present = make_partition(task.grid, settings, *task.before, n_ranks, nullptr, task.cost);
    const Partition* const left = present ? &*present : nullptr;
    PartitionNotes notes;
    Partition partition;
    row.seconds =
        time_of([&] { partition = make_partition(task.grid, settings, task.load, n_ranks, left, task.cost, &notes); });
    row.chosen = (notes.rebalanced ? "rebalanced " : "") + name_of(notes.method);
    row.remarks = notes.warnings;
    describe(task, partition, row);
    if (left) row.moved = moved_part(task, *left, partition);
    std::vector<PartitionRow> rows{row};
    const auto add = [&](const char* way, double seconds, const Partition& changed) {
      PartitionRow& other = rows.emplace_back(row);
      other.chosen = way;
      other.remarks.clear();
      other.seconds = seconds;
      describe(task, changed, other);
      other.moved = moved_part(task, *left, changed);
    };
    if (left && method == PartitionMethod::automatic) {
      std::array<Partition, 2> changed;
      const double seconds = time_of([&] { changed = rebalanced(task.grid, task.load, *left); });
      add("handed on", seconds, changed[0]);
      add("straight", seconds, changed[1]);
    }
    const bool cuts = method == PartitionMethod::bisection || method == PartitionMethod::hilbert;
    if (left && cuts && n_ranks > 1) {
      Partition changed;
      double seconds = time_of([&] { changed = *recut(task.grid, task.load, *left, KeptCuts::tight_tolerance); });
      add("kept within 2 %", seconds, changed);
      seconds = time_of([&] { changed = make_partition(task.grid, settings, task.load, n_ranks, nullptr, task.cost); });
      add("made anew", seconds, changed);
    }
    return rows;
  } catch (const UsageError& error) {
    row.chosen.clear();
    row.remarks = {error.what()};
    return {row};
  }
}

std::string label(const PartitionRow& row) {
  return row.chosen.empty() || row.chosen == row.method ? row.method : fmt::format("{} ({})", row.method, row.chosen);
}

/// About three digits, without an exponent.
std::string short_text(double value) {
  const int digits = value < 10.0 ? 2 : value < 100.0 ? 1 : 0;
  return fmt::format("{:.{}f}", value, value < 1.0 ? 3 : digits);
}

std::string percentage(double part) { return std::isnan(part) ? "-" : fmt::format("{:.1f}", 100.0 * part); }

std::string csv_number(double value) { return std::isnan(value) ? std::string() : fmt::format("{:.9g}", value); }

}  // namespace

std::vector<std::string> partition_method_names() {
  std::vector<std::string> result;
  for (const auto& [name, method] : names(config::Of<PartitionMethod>{})) result.push_back(name);
  return result;
}

std::optional<PartitionMethod> partition_method(const std::string& name) {
  for (const auto& [known, method] : names(config::Of<PartitionMethod>{}))
    if (known == name) return method;
  return std::nullopt;
}

std::vector<PartitionRow> partition_rows(const PartitionTask& task, std::span<const PartitionMethod> methods, int n_ranks) {
  std::vector<PartitionRow> rows;
  for (const PartitionMethod method : methods)
    for (PartitionRow& row : rows_of(task, method, n_ranks)) rows.push_back(std::move(row));
  return rows;
}

std::string partition_table(std::span<const PartitionRow> rows) {
  if (rows.empty()) return {};
  std::string text = fmt::format("\n{:<28}{:>8}{:>10}{:>8}{:>14}{:>16}{:>9}{:>14}{:>10}{:>7}{:>11}\n",
                                 fmt::format("{} ranks", rows.front().n_ranks), "load", "particles", "halo/", "neighbours",
                                 "KiB sent", "off node", "messages", "step", "moved", "partition");
  text += fmt::format("{:<28}{:>8}{:>10}{:>8}{:>8}{:>6}{:>8}{:>8}{:>9}{:>8}{:>6}{:>10}{:>7}{:>11}\n", "", "max/mean",
                      "max/mean", "worked", "mean", "max", "mean", "max", "[%]", "mean", "max", "[ms]", "[%]", "[ms]");
  for (const PartitionRow& row : rows) {
    constexpr double kib = 1024.0, milli = 1e3;
    if (!row.chosen.empty())
      text += fmt::format(
          "{:<28}{:>8.3f}{:>10.3f}{:>8.2f}{:>8.1f}{:>6.0f}{:>8}{:>8}{:>9}{:>8.1f}{:>6.0f}{:>10}{:>7}{:>11}\n", label(row),
          row.load, row.particles, row.halo, row.neighbours_mean, row.neighbours_max, short_text(row.bytes_mean / kib),
          short_text(row.bytes_max / kib), percentage(row.off_node), row.messages_mean, row.messages_max,
          short_text(row.step_seconds * milli), percentage(row.moved), short_text(row.seconds * milli));
    for (const std::string& remark : row.remarks) text += fmt::format("{}: {}\n", row.method, remark);
  }
  return text;
}

std::string partition_csv(const PartitionTask& task, std::span<const PartitionRow> rows) {
  std::string text =
      "ranks,method,chosen,load_max_over_mean,particles_max_over_mean,halo_over_worked_nodes,neighbours_mean,neighbours_max,"
      "sent_mean [B],sent_max [B],sent_off_node_fraction,messages_mean,messages_max,predicted_step [s],moved_fraction,"
      "partition_time [s],n_particles,n_tiles,cells_x,cells_y,cells_z\n";
  for (const PartitionRow& row : rows) {
    text += fmt::format("{},{},{},", row.n_ranks, row.method, row.chosen);
    if (row.chosen.empty())
      text += ",,,,,,,,,,,,,";
    else
      text += fmt::format("{:.9g},{:.9g},{:.9g},{:.9g},{:.0f},{:.12g},{:.0f},{},{:.9g},{:.0f},{:.9g},{},{:.6g},", row.load,
                          row.particles, row.halo, row.neighbours_mean, row.neighbours_max, row.bytes_mean, row.bytes_max,
                          csv_number(row.off_node), row.messages_mean, row.messages_max, row.step_seconds,
                          csv_number(row.moved), row.seconds);
    text += fmt::format("{},{},{},{},{}\n", task.n_particles, task.load.size(), task.grid.n_cells[0], task.grid.n_cells[1],
                        task.grid.n_cells[2]);
  }
  return text;
}

}  // namespace bulkley
