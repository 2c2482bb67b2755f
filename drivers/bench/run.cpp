#include "bench/run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <numeric>
#include <thread>

#include "bench/machine.hpp"
#include "bench/naive_kernel.hpp"
#include "io/status/status.hpp"
#include "simulation/forecast.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

namespace {

constexpr int naive_steps = 3;  // of a block of the naive kernel

// A barrier whose waiting ranks leave their cores to others, which one of MPI does not.
void sleeping_barrier(const Comm& comm) {
  MPI_Request request;
  BULKLEY_MPI(MPI_Ibarrier(comm.get(), &request));
  for (int arrived = 0;;) {
    BULKLEY_MPI(MPI_Test(&request, &arrived, MPI_STATUS_IGNORE));
    if (arrived) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

BenchRun::BenchRun(const Comm& comm, const BenchCase& what) : comm_(comm) {
  const Scene scene = bench_scene(what);
  const TileCensus census = seeded_census(comm, scene);
  Partition partition = first_partition(comm, scene, census, assumed_cost(scene));
  ParticleSet particles = seed_share(comm, scene, partition, census);
  start_shear(what, scene, particles);
  solver_ = std::make_unique<Solver>(comm, physics_of(scene), std::move(partition), std::move(particles), std::nullopt);
  mach_number_ = solver_->bounds().motion.speed.value / bench_wave_speed(what);
  state_.dt_stable = solver_->dt_limit(0.0, scene.time_stepping.end_time).dt;
  state_.wait = scene.time_stepping.trial_interval;
  state_.dt_first_limit = state_.dt_stable;
  advance(block_steps);
  solver_->times() = {};
  n_steps_ = n_iterations_ = n_rounds_ = 0;
}

double BenchRun::advance(int n_steps) {
  BULKLEY_MPI(MPI_Barrier(comm_.get()));
  const double begin = MPI_Wtime();
  for (int k = 0; k < n_steps; ++k) {
    const StepReport report = solver_->step({time_, solver_->physics().time_stepping.end_time}, state_);
    time_ += report.plan.dt;
    n_iterations_ += report.pressure.n_iterations;
    n_rounds_ += report.pressure.n_rounds;
  }
  n_steps_ += n_steps;
  return max_global(comm_, MPI_Wtime() - begin) / n_steps;
}

std::vector<std::pair<std::string, double>> BenchRun::phases() const {
  std::vector<std::pair<std::string, double>> result;
  for (const PhaseSummary& phase : summarize(comm_, solver_->times()))
    result.emplace_back(phase.name, phase.mean / static_cast<double>(n_steps_) * scale());
  return result;
}

double BenchRun::sorts_per_step() const {
  return static_cast<double>(solver_->times()[Phase::sort].n_calls) / static_cast<double>(n_steps_);
}

double BenchRun::yielded_fraction() const {
  const ParticleSet& particles = solver_->particles();
  const double* rate = particles.real(Field::plastic_shear_rate);
  const GlobalIndex n = std::count_if(rate, rate + particles.size(), [](double r) { return r > 0.0; });
  return static_cast<double>(sum_global(comm_, n)) / static_cast<double>(n_particles());
}

std::vector<std::vector<double>> time_in_turn(int n_rounds, const std::vector<Block>& blocks) {
  std::vector<std::vector<double>> seconds(blocks.size());
  for (int round = 0; round < n_rounds; ++round)
    for (std::size_t b = 0; b < blocks.size(); ++b) seconds[b].push_back(blocks[b]());
  return seconds;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double on_root_alone(const Comm& comm, const Block& work) {
  double result = 0.0;
  std::exception_ptr failure;
  if (comm.is_root()) try {
      result = work();
    } catch (...) {
      failure = std::current_exception();
    }
  sleeping_barrier(comm);
  root_guard(comm, [&] {
    if (failure) std::rethrow_exception(failure);
  });
  return result;
}

namespace {

// The results of a run in addition to the times of its blocks. Collective.
BenchResult facts_of(const Comm& comm, const BenchCase& what, BenchRun& run) {
  BenchResult facts;
  facts.n_particles = run.n_particles();
  facts.n_ranks = comm.size();
  facts.phases = run.phases();
  facts.sorts_per_step = run.sorts_per_step();
  facts.yielded_fraction = run.yielded_fraction();
  facts.mach_number = run.mach_number();
  facts.forecast_bytes_per_particle = forecast(comm, bench_scene(what), comm.size()).bytes_per_particle;
  const Exchange& exchange = run.solver().exchange();
  const auto n_nodes = static_cast<GlobalIndex>(exchange.active_nodes().size());
  facts.nodes_per_particle = static_cast<double>(sum_global(comm, n_nodes)) / static_cast<double>(facts.n_particles);
  // Once to the owners and once back, for each vector of nodes.
  const int n_vectors = what.transfer.keeps_residual() ? 2 : 1;
  const Exchange::Traffic add = exchange.sent_by_add(), get = exchange.sent_by_get();
  facts.exchange_bytes_per_step = n_vectors * max_global(comm, static_cast<double>(add.bytes + get.bytes));
  facts.exchange_messages_per_step = n_vectors * max_global(comm, GlobalIndex{add.n_messages + get.n_messages});
  if (what.integrator == IntegratorKind::imex) {
    facts.iterations_per_step = run.iterations_per_step();
    facts.rounds_per_step = run.rounds_per_step();
    const auto bytes = static_cast<double>(run.solver().integrator().bytes_per_iteration());
    facts.exchange_bytes_per_iteration = max_global(comm, bytes);
  }
  return facts;
}

// Whether the root has the memory to compute the case alone. Collective.
bool fits_on_root(const Comm& comm, const BenchCase& what) {
  const bool fits = fits_into_memory(forecast(comm, bench_scene(what), 1).bytes_per_rank);
  return min_global(comm, GlobalIndex{fits}) == 1;
}

}  // namespace

BenchResult run_bench(const Comm& comm, const BenchCase& what, const BenchEffort& effort) {
  const auto empty_program = static_cast<GlobalIndex>(peak_resident_bytes());
  BenchRun run(comm, what);
  const GlobalIndex occupied = static_cast<GlobalIndex>(peak_resident_bytes()) - empty_program;
  const auto n = static_cast<double>(run.n_particles());

  const bool with_one_rank = effort.one_rank && comm.size() > 1 && fits_on_root(comm, what);
  std::unique_ptr<Comm> alone;  // the root's communicator with itself
  std::unique_ptr<BenchRun> one_rank;
  std::unique_ptr<NaiveKernel> naive;
  on_root_alone(comm, [&] {
    if (with_one_rank) {
      alone = std::make_unique<Comm>(MPI_COMM_SELF);
      one_rank = std::make_unique<BenchRun>(*alone, what);
    }
    if (effort.naive) naive = std::make_unique<NaiveKernel>(cells_along_box(what), ball_radius);
    return 0.0;
  });

  std::vector<Block> blocks{[&] { return run.advance(block_steps); }};
  std::unique_ptr<BenchRun> explicit_run;
  if (what.integrator == IntegratorKind::imex) {
    BenchCase explicit_case = what;
    explicit_case.integrator = IntegratorKind::explicit_step;
    explicit_run = std::make_unique<BenchRun>(comm, explicit_case);
    blocks.push_back([&] { return explicit_run->advance(block_steps); });
  }
  if (effort.naive)
    blocks.push_back([&] {
      return on_root_alone(comm, [&] {
        double seconds = 0.0;
        for (int k = 0; k < naive_steps; ++k) seconds += naive->step();
        return seconds / naive_steps / static_cast<double>(naive->size()) * n;  // for as many particles as the real step
      });
    });
  if (with_one_rank) blocks.push_back([&] { return on_root_alone(comm, [&] { return one_rank->advance(block_steps); }); });
  const auto seconds = time_in_turn((effort.n_steps + block_steps - 1) / block_steps, blocks);

  BenchResult result = facts_of(comm, what, run);
  result.bytes_per_particle = static_cast<double>(sum_global(comm, occupied)) / n;
  result.ns = mean(seconds[0]) * run.scale();
  if (effort.naive) {
    const double naive_seconds = mean(seconds[explicit_run ? 2 : 1]);
    result.naive_ns = naive_seconds / n * 1e9;
    result.ratio_to_naive = mean(seconds[0]) / naive_seconds * comm.size();
  }
  if (explicit_run) {
    result.explicit_ns = mean(seconds[1]) * explicit_run->scale();
    result.ratio_to_explicit = mean(seconds[0]) / mean(seconds[1]);
  }
  if (with_one_rank) {
    result.one_rank_ns = mean(seconds.back()) / n * 1e9;
    result.throughput_ratio = mean(seconds.back()) / mean(seconds[0]);
  }
  return result;
}

}  // namespace bulkley
