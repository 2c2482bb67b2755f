#include "bench/suite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/bounds.hpp"
#include "bench/child.hpp"
#include "bench/count.hpp"
#include "bench/field_solve.hpp"
#include "bench/machine.hpp"
#include "bench/report.hpp"
#include "bench/row.hpp"
#include "bulkley/base/pack.hpp"
#include "integrator/magnetic_force.hpp"
#include "parallel/log.hpp"
#include "program/version.hpp"
#include "scene/time_step_keys.hpp"
#include "simulation/forecast.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

namespace {

// Of the magnetic field so far.
double n_solutions(BenchRun& run) {
  const auto& columns = MagneticFigures::columns();
  const auto found = std::find(columns.begin(), columns.end(), "magnetic_solves");
  return run.solver().force_history()[static_cast<std::size_t>(found - columns.begin())];
}

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

std::string count_text(GlobalIndex n) {
  return n >= 1'000'000 ? fmt::format("{} M", n / 1'000'000) : fmt::format("{} k", n / 1000);
}

// A measured value of a case's JSON; NaN where it was not measured.
double number_of(const Json& json, const char* key) {
  const Json& value = json.at(key);
  return value.is_number() ? value.get<double>() : undefined;
}

class Suite {
 public:
  Suite(const Comm& comm, bool small) : comm_(comm), small_(small), machine_(measure_machine()) {
    log_line(comm_, row_heading());
  }

  void floor();
  void all_cases();
  void sizes();
  void domain();
  void memory();
  void ranks();
  void cores();
  void imex();
  void field();
  void field_step();
  Json json() const;

 private:
  void add(Row row);
  void sizes_of(const std::string& material);
  Row bytes_row(const BoundedCase& c, const BenchCase& what, const BenchResult& result, Json& details) const;
  Row child_row(const std::string& part, const std::string& name, int n_ranks, const std::string& material, GlobalIndex n,
                int n_steps, const std::function<void(const Json& json, Row& row)>& read,
                IntegratorKind integrator = IntegratorKind::explicit_step) const;
  std::array<double, 2> ns_of_runs(int n_runs, std::string& fault) const;
  static std::function<void(const Json& json, Row& row)> throughput(const Bound& bound);
  GlobalIndex usual_size() const { return small_ ? 100'000 : 1'000'000; }
  int n_rounds() const { return small_ ? 3 : 5; }
  // Whether the memory that is free holds a case so many times.
  bool fits(const BenchCase& what, int n_copies = 1) const {
    return fits_into_memory(forecast(comm_, bench_scene(what), 1).bytes_per_rank * n_copies);
  }

  const Comm& comm_;
  bool small_;
  MachineLimits machine_;
  std::vector<Row> rows_;
};

void Suite::add(Row row) {
  log_line(comm_, row_line(row));
  rows_.push_back(std::move(row));
}

void Suite::floor() {
  add({.part = "floor", .name = "triad, 24 bytes an element", .value = machine_.triad_bandwidth / 1e9, .unit = "GB/s"});
  add({.part = "floor",
       .name = "triad, with the lines read before written",
       .value = machine_.traffic_bandwidth / 1e9,
       .unit = "GB/s"});
  add({.part = "floor",
       .name = fmt::format("fused products and sums, {} lanes", n_lanes),
       .value = machine_.flops / 1e9,
       .unit = "Gflop/s"});
}

// How near a case comes to what its bytes take at the triad's rate; the count goes to `details`.
Row Suite::bytes_row(const BoundedCase& c, const BenchCase& what, const BenchResult& result, Json& details) const {
  const Scene scene = bench_scene(what);
  const bool flows = std::holds_alternative<HerschelBulkley>(scene.materials.front().material);
  const bool shares = !sharing_materials(scene).empty();
  const bool stores = optional_fields(scene).contains(Field::kirchhoff_stress);
  double bytes = 0.0, flops = 0.0;
  Json terms = Json::array();
  for (const WorkTerm& term : count_work({what.transfer, flows, shares, stores, result.sorts_per_step, result.nodes_per_particle})) {
    bytes += term.bytes;
    flops += term.flops;
    terms.push_back({{"what", term.what}, {"bytes", rounded(term.bytes)}, {"flops", rounded(term.flops)}});
  }
  const double memory_ns = 1e9 * bytes / machine_.traffic_bandwidth, flops_ns = 1e9 * flops / machine_.flops;
  const double bound = std::max(memory_ns, flops_ns), sum = memory_ns + flops_ns;
  details["bytes_per_particle_step"] = rounded(bytes);
  details["flops_per_particle_step"] = rounded(flops);
  details["memory_ns"] = rounded(memory_ns);
  details["flops_ns"] = rounded(flops_ns);
  details["floor_ns"] = rounded(bound);
  details["step_over_floor"] = rounded(result.ns / bound);
  details["step_over_sum"] = rounded(result.ns / sum);
  details["count"] = std::move(terms);
  return {.part = "cases",
          .name = fmt::format("{}: time of its bytes", c.name),
          .value = memory_ns / result.ns,
          .unit = "of step",
          .note = fmt::format("{:.0f} B in {:.1f} ns, {:.0f} flops in {:.1f} ns: step is {:.2f} x the larger, {:.2f} x their sum",
                              bytes, memory_ns, flops, flops_ns, result.ns / bound, result.ns / sum)};
}

void Suite::all_cases() {
  for (const BoundedCase& c : bounded_cases()) {
    const BenchCase what{usual_size(), c.material, c.transfer, {1, 1, 1}};
    const BenchResult result = run_bench(comm_, what, {n_rounds() * block_steps, true, false});
    Json details = describe(what, result);
    Row bytes = bytes_row(c, what, result, details);
    std::string phases;
    for (const auto& [name, ns] : result.phases)
      if (ns >= 0.05) phases += fmt::format("{}{} {:.1f}", phases.empty() ? "" : ", ", name, ns);
    add({.part = "cases",
         .name = c.name,
         .value = result.ratio_to_naive,
         .unit = "of naive",
         .bound = c.ratio_to_naive,
         .note = fmt::format("{:.1f} ns, naive {:.1f}: {}; {:.0f} % yield, Ma {:.2f}", result.ns, result.naive_ns, phases,
                             100.0 * result.yielded_fraction, result.mach_number),
         .details = std::move(details)});
    add(std::move(bytes));
  }
}

void Suite::sizes_of(const std::string& material) {
  std::vector<std::unique_ptr<BenchRun>> runs;
  std::vector<std::string> names;
  std::vector<Block> blocks;
  std::string missing;
  for (const GlobalIndex n :
       small_ ? std::vector<GlobalIndex>{100'000, 400'000} : std::vector<GlobalIndex>{100'000, 1'000'000, 10'000'000}) {
    const BenchCase what{n, material, {}, {1, 1, 1}};
    if (!fits(what)) {
      missing += fmt::format("; {} particles do not fit into the memory that is free", count_text(n));
      continue;
    }
    runs.push_back(std::make_unique<BenchRun>(comm_, what));
    names.push_back(fmt::format("{}, {}", material, count_text(n)));
    // The small balls reach their walls after some hundred steps, the large ones take long.
    blocks.push_back([run = runs.back().get()] { return run->advance(block_steps) * run->scale(); });
  }
  const std::vector<std::vector<double>> ns = time_in_turn(3, blocks);
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    add({.part = "sizes", .name = names[r], .value = mean(ns[r]), .unit = "ns"});
    const double relative = mean(ns[r]) / mean(ns[0]);
    least = std::min(least, relative);
    most = std::max(most, relative);
  }
  const std::string name = material + ", max/min cost over sizes";
  if (runs.size() < 2)
    add(row_without_value("sizes", name, "skipped", "fewer than two sizes" + missing));
  else
    add({.part = "sizes",
         .name = name,
         .value = most / least,
         .unit = "",
         .bound = bench_bounds::spread_over_sizes,
         .note = "timed in turn" + missing});
}

void Suite::sizes() {
  sizes_of("neo_hookean");
  sizes_of("cream");
}

void Suite::domain() {
  const BenchCase box{usual_size(), "cream", {}, {1, 1, 1}};
  BenchCase large = box;
  large.domain = {2, 2, 4};
  const std::string name = "domain of 16 times the ball's box";
  if (!fits(large)) {
    add(row_without_value("domain", name, "skipped", "it does not fit into the memory that is free"));
    return;
  }
  BenchRun in_box(comm_, box), in_large(comm_, large);
  const auto seconds =
      time_in_turn(n_rounds(), {[&] { return in_box.advance(block_steps); }, [&] { return in_large.advance(block_steps); }});
  add({.part = "domain",
       .name = name,
       .value = mean(seconds[1]) / mean(seconds[0]),
       .unit = "of box",
       .bound = bench_bounds::empty_domain,
       .note = fmt::format("{:.4g} against {:.4g} ms a step", 1e3 * mean(seconds[1]), 1e3 * mean(seconds[0]))});
}

// A run of its own process on `n_ranks` ranks; `read` fills the row from what it wrote.
Row Suite::child_row(const std::string& part, const std::string& name, int n_ranks, const std::string& material,
                     GlobalIndex n, int n_steps, const std::function<void(const Json& json, Row& row)>& read,
                     IntegratorKind integrator) const {
  if (const std::string skip_reason = child_obstacle(n_ranks); !skip_reason.empty())
    return row_without_value(part, name, "skipped", skip_reason);
  if (!fits({n, material, {}, {1, 1, 1}}, n_ranks > 1 ? 2 : 1))  // on all ranks, and on one alone
    return row_without_value(part, name, "skipped", "it does not fit into the memory that is free");
  const double time_limit = 60.0 + 1e-5 * static_cast<double>(n) * n_steps;  // s; 10 us for a particle's step
  const ChildOutcome outcome = run_child_bench(n_ranks,
                                               {"--particles", std::to_string(n), "--material", material, "--steps",
                                                std::to_string(n_steps), "--integrator", name_of(integrator), "--no-naive"},
                                               time_limit);
  if (!outcome.fault.empty()) return row_without_value(part, name, "failed", outcome.fault);
  Row row{.part = part, .name = name};
  read(outcome.json, row);
  return row;
}

void Suite::memory() {
  for (const GlobalIndex n :
       small_ ? std::vector<GlobalIndex>{100'000} : std::vector<GlobalIndex>{100'000, 1'000'000, 10'000'000}) {
    double forecast_bytes = undefined;
    Row measured = child_row("memory", count_text(n), 1, "cream", n, block_steps, [&](const Json& json, Row& row) {
      row.value = number_of(json, "bytes_per_particle");
      row.unit = "B a particle";
      if (n == 1'000'000) row.bound = bench_bounds::bytes_per_particle;
      forecast_bytes = number_of(json, "forecast_bytes_per_particle");
    });
    const double ratio = measured.value / forecast_bytes;
    const std::string name = measured.name + ", measured and predicted";
    const bool has_value = measured.skip_reason.empty();
    add(std::move(measured));
    if (has_value)
      add({.part = "memory",
           .name = name,
           .value = std::max(ratio, 1.0 / ratio),
           .unit = "apart",
           .bound = bench_bounds::forecast_error,
           .note = fmt::format("predicted {:.4g} B a particle", forecast_bytes)});
  }
}

std::function<void(const Json& json, Row& row)> Suite::throughput(const Bound& bound) {
  return [bound](const Json& json, Row& row) {
    row.value = number_of(json, "throughput_ratio");
    row.unit = "of one rank";
    row.bound = bound;
    const double bytes = number_of(json, "exchange_bytes_per_step");
    const double messages = number_of(json, "exchange_messages_per_step");
    row.note = fmt::format("busiest rank and step: {:.0f} bytes in {:.0f} messages", bytes, messages);
    for (const char* key :
         {"exchange_bytes_per_step", "exchange_messages_per_step", "ns_per_particle_step", "one_rank_ns_per_particle_step"})
      row.details[key] = json.at(key);
  };
}

void Suite::ranks() {
  const int n_steps = n_rounds() * block_steps;
  if (n_usable_cores() < 2)
    add(row_without_value("ranks", "throughput of 2 ranks", "skipped", "this process may use one core only"));
  else
    add(child_row("ranks", "throughput of 2 ranks", 2, "cream", usual_size(), n_steps, throughput(bench_bounds::two_ranks)));
  add(child_row("ranks", fmt::format("throughput of 8 ranks on {} cores", n_usable_cores()), 8, "cream", usual_size(),
                block_steps, throughput(bench_bounds::eight_ranks)));
}

// Mean and largest cost of so many runs of one rank beside each other, ns a particle and step.
std::array<double, 2> Suite::ns_of_runs(int n_runs, std::string& fault) const {
  std::vector<ChildOutcome> outcomes(static_cast<std::size_t>(n_runs));
  std::vector<std::thread> waiting;
  for (ChildOutcome& outcome : outcomes)
    waiting.emplace_back([&outcome, this] {
      outcome = run_child_bench(
          1, {"--particles", std::to_string(usual_size()), "--steps", std::to_string(2 * block_steps), "--no-naive"}, 300.0);
    });
  for (std::thread& thread : waiting) thread.join();
  std::vector<double> ns;
  for (const ChildOutcome& outcome : outcomes) {
    if (!outcome.fault.empty()) fault = outcome.fault;
    ns.push_back(outcome.fault.empty() ? number_of(outcome.json, "ns_per_particle_step") : undefined);
  }
  return {mean(ns), *std::max_element(ns.begin(), ns.end())};
}

// Runs of one rank each beside each other, and one beside cores that only stream memory: what a full node leaves to a rank.
void Suite::cores() {
  const int n_cores = n_usable_cores();
  const std::string full = fmt::format("a run of one rank on each of {} cores", n_cores),
                    starved = "beside streams of memory";
  std::string obstacle = child_obstacle(1);
  if (obstacle.empty() && n_cores < 2) obstacle = "this process may use one core only";
  const BenchCase run{usual_size(), "cream", {}, {1, 1, 1}};
  if (obstacle.empty() && !(fits(run, n_cores) && fits_into_memory(MemoryStreams::memory(n_cores))))
    obstacle = "they do not fit into the memory that is free";
  if (!obstacle.empty()) {
    for (const std::string& name : {full, starved}) add(row_without_value("cores", name, "skipped", obstacle));
    return;
  }
  std::string fault;
  std::vector<double> alone, together, slowest, beside, streamed;
  for (int round = 0; round < (small_ ? 1 : 2); ++round) {
    alone.push_back(ns_of_runs(1, fault)[0]);
    const std::array<double, 2> all = ns_of_runs(n_cores, fault);
    together.push_back(all[0]);
    slowest.push_back(all[1]);
    const MemoryStreams streams(n_cores - 1);
    beside.push_back(ns_of_runs(1, fault)[0]);
    streamed.push_back(streams.traffic_bandwidth() / (n_cores - 1));
  }
  if (!fault.empty()) {
    for (const std::string& name : {full, starved}) add(row_without_value("cores", name, "failed", fault));
    return;
  }
  add({.part = "cores",
       .name = full,
       .value = mean(together) / mean(alone),
       .unit = "of alone",
       .note =
           fmt::format("cream, {:.1f} ns, the slowest {:.1f}; alone {:.1f}", mean(together), mean(slowest), mean(alone))});
  add({.part = "cores",
       .name = starved,
       .value = mean(beside) / mean(alone),
       .unit = "of alone",
       .note = fmt::format("cream, {:.1f} ns; {} of {} cores stream {:.1f} GB/s each", mean(beside), n_cores - 1, n_cores,
                           1e-9 * mean(streamed))});
}

void Suite::imex() {
  BenchCase what{usual_size(), "cream", {}, {1, 1, 1}};
  what.integrator = IntegratorKind::imex;
  const BenchResult result = run_bench(comm_, what, {n_rounds() * block_steps, false, false});
  std::string phases;
  for (const auto& [name, ns] : result.phases)
    if (ns >= 0.05) phases += fmt::format("{}{} {:.1f}", phases.empty() ? "" : ", ", name, ns);
  add({.part = "imex",
       .name = fmt::format("cream, {:.0e} Pa", bench_bulk_modulus),
       .value = result.ratio_to_explicit,
       .unit = "of explicit",
       .bound = bench_bounds::imex_step,
       .note = fmt::format("{:.1f} ns, explicit {:.1f}; {:.1f} iterations in {:.1f} rounds a step: {}", result.ns,
                           result.explicit_ns, result.iterations_per_step, result.rounds_per_step, phases),
       .details = describe(what, result)});
  if (n_usable_cores() < 2)
    add(row_without_value("imex", "throughput of 2 ranks", "skipped", "this process may use one core only"));
  else
    add(child_row("imex", "throughput of 2 ranks", 2, "cream", usual_size(), n_rounds() * block_steps,
                  throughput(bench_bounds::imex_two_ranks), IntegratorKind::imex));
}

void Suite::field() {
  double smaller = undefined;
  for (const int n_cells : small_ ? std::vector<int>{32, 64} : std::vector<int>{64, 128}) {
    FieldSolve field(comm_, n_cells);
    const auto set_up = [&](FieldSolver solver) { return Block([&field, solver] { return field.prepare(solver); }); };
    const auto iterate = [&](FieldSolver solver) { return Block([&field, solver] { return field.solve(solver).seconds; }); };
    const std::vector<std::vector<double>> seconds = time_in_turn(
        n_rounds(),
        {iterate(FieldSolver::own), iterate(FieldSolver::petsc), set_up(FieldSolver::own), set_up(FieldSolver::petsc)});
    std::vector<double> ns;
    for (const auto& each : seconds) ns.push_back(1e9 * mean(each) / static_cast<double>(field.n_nodes()));
    const std::string name = fmt::format("magnetic field, {}^3 nodes", n_cells + 1);
    add({.part = "field",
         .name = name,
         .value = ns[0],
         .unit = "ns",
         .note = fmt::format("a node and iteration, {} to 1e-8; {:.0f} B in {:.1f} ns; set-up {:.0f} ns a node",
                             field.solve(FieldSolver::own).n_iterations, bytes_of_potential,
                             1e9 * bytes_of_potential / machine_.traffic_bandwidth, ns[2])});
    add({.part = "field",
         .name = name + ", by PETSc",
         .value = ns[1],
         .unit = "ns",
         .note = fmt::format("{} iterations, {:.1f} x our own; set-up {:.0f} ns a node",
                             field.solve(FieldSolver::petsc).n_iterations, ns[1] / ns[0], ns[3])});
    if (!std::isnan(smaller))
      add({.part = "field",
           .name = name + ", over an eighth",
           .value = ns[0] / smaller,
           .unit = "",
           .bound = small_ ? Bound{} : bench_bounds::potential_growth});  // small ones are in cache or not
    smaller = ns[0];
  }
  field_step();
}

// As slow as the solutions can wait for: a particle crosses a quarter of a cell in some fifteen steps.
void Suite::field_step() {
  BenchCase what{usual_size(), "ferro_oobleck", {}, {1, 1, 1}};
  what.mach_number = 0.05;
  what.gravity = 0.0;  // the speed stays
  BenchRun plain(comm_, what);
  what.magnetic_field = true;
  BenchRun forced(comm_, what);
  constexpr int n_blocks = 4;  // several solutions a round
  const auto advance = [](BenchRun& run) { return Block([&run] { return run.advance(n_blocks * block_steps); }); };
  const double solved_before = n_solutions(forced);
  const auto seconds = time_in_turn(n_rounds(), {advance(plain), advance(forced)});
  const double n_steps = 1.0 * n_rounds() * n_blocks * block_steps;
  add({.part = "field",
       .name = "a step with a magnetic field",
       .value = mean(seconds[1]) / mean(seconds[0]),
       .unit = "of plain",
       .bound = small_ ? Bound{} : bench_bounds::field_step,
       .note = fmt::format("{:.1f} ns, plain {:.1f}; a solution every {:.1f} steps", mean(seconds[1]) * forced.scale(),
                           mean(seconds[0]) * plain.scale(), n_steps / (n_solutions(forced) - solved_before))});
}

Json Suite::json() const {
  Json rows = Json::array();
  for (const Row& row : rows_) rows.push_back(describe(row));
  return {{"version", version_text()},
          {"machine",
           {{"triad_bytes_per_second", rounded(machine_.triad_bandwidth)},
            {"traffic_bytes_per_second", rounded(machine_.traffic_bandwidth)},
            {"flops_per_second", rounded(machine_.flops)},
            {"lanes", n_lanes},
            {"usable_cores", n_usable_cores()}}},
          {"rows", rows}};
}

struct Part {
  const char* name;
  void (Suite::*run)();
};
constexpr Part parts[] = {{"floor", &Suite::floor},   {"cases", &Suite::all_cases}, {"sizes", &Suite::sizes},
                          {"domain", &Suite::domain}, {"memory", &Suite::memory},   {"ranks", &Suite::ranks},
                          {"cores", &Suite::cores},   {"imex", &Suite::imex},       {"field", &Suite::field}};

}  // namespace

const std::vector<std::string>& suite_parts() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Part& part : parts) result.emplace_back(part.name);
    return result;
  }();
  return names;
}

Json run_suite(const Comm& comm, const SuiteSettings& settings) {
  if (comm.size() > 1) throw UsageError("--suite: must run in one process; it starts the runs on several ranks itself");
  const auto wanted = [&](const char* name) {
    return settings.parts.empty() || std::find(settings.parts.begin(), settings.parts.end(), name) != settings.parts.end();
  };
  Suite suite(comm, settings.small);
  for (const Part& part : parts)
    if (wanted(part.name)) (suite.*part.run)();
  return suite.json();
}

}  // namespace bulkley
