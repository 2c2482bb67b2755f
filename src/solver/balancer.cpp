#include "bulkley/solver/balancer.hpp"

#include <algorithm>

#include "bulkley/domain/traffic.hpp"
#include "bulkley/solver/solver.hpp"

namespace bulkley {

namespace {

constexpr double least_gain = 0.02;   // of the time of a step
constexpr double even_enough = 1.02;  // what a partition can be expected to reach, largest over mean load

// Of a new measurement in the running mean; single ones are noisy.
constexpr double newest_weight = 0.25;

// Particles that the busiest rank sends or receives in going from one map to the other.
GlobalIndex busiest_moves(const Partition& from, const Partition& to, const TileLoad& load) {
  std::vector<GlobalIndex> of_rank(static_cast<std::size_t>(from.size()), 0);
  for (std::size_t t = 0; t < load.size(); ++t) {
    const auto tile = static_cast<std::size_t>(load.tile[t]);
    if (from.worker[tile] == to.worker[tile]) continue;
    of_rank[static_cast<std::size_t>(from.worker[tile])] += load.count[t];
    of_rank[static_cast<std::size_t>(to.worker[tile])] += load.count[t];
  }
  return *std::max_element(of_rank.begin(), of_rank.end());
}

void average_in(double& mean, double value, bool first) { mean = first ? value : mean + newest_weight * (value - mean); }

}  // namespace

std::optional<Partition> worthwhile_change(const GridGeometry& grid, const TileLoad& load, const Partition& present,
                                           const CostModel& cost, const ChangeCost& change, double horizon) {
  const std::vector<GlobalIndex> loads = rank_loads(present, load, present.size());
  const double largest = 1e-12 * static_cast<double>(*std::max_element(loads.begin(), loads.end()));
  const double mean = 1e-12 * static_cast<double>(load.total()) / present.size();
  const double now = predicted_step(predict_traffic(grid, present, load), cost);
  // What even loads alone could save; the bytes to send may grow or shrink a little.
  const double most = largest - even_enough * mean;
  if (most < least_gain * now || most * horizon <= change.rebuild) return std::nullopt;

  struct Candidate {
    Partition partition;
    double step, net;  // s: of a step; saved over the horizon less the cost
  };
  const auto judged = [&](Partition partition, double making) {
    const double step = predicted_step(predict_traffic(grid, partition, load), cost);
    const double moving = change.particle * static_cast<double>(busiest_moves(present, partition, load));
    return Candidate{std::move(partition), step, (now - step) * horizon - making - change.rebuild - moving};
  };
  Candidate best = judged(rebalanced(grid, load, present), 0.0);
  const double making = change.tile * static_cast<double>(load.size());
  if (most * horizon - making - change.rebuild > std::max(best.net, 0.0)) {
    Candidate other = judged(make_partition(grid, {PartitionMethod::automatic}, load, present.size(), &present, cost), making);
    if (other.net > best.net) best = std::move(other);
  }
  if (best.net <= 0.0 || now - best.step < least_gain * now) return std::nullopt;
  return std::move(best.partition);
}

Balancer::Balancer(const Comm& comm, const PartitionSettings& settings, CostModel cost, GlobalIndex step)
    : comm_(comm), settings_(settings), cost_(std::move(cost)), last_look_(step), last_change_(step) {
  measured_ = !cost_.particle.empty();
}

void Balancer::after_step(Solver& solver, GlobalIndex step) {
  if (comm_.size() == 1) return;
  const auto due = [step](int interval) { return interval > 0 && step % interval == 0; };
  const bool forced = due(settings_.remake_interval);
  if (!forced && !(settings_.method == PartitionMethod::automatic && due(settings_.decision_interval))) return;

  const double begin = MPI_Wtime();
  std::optional<Partition> next;
  {
    const Phase phase(solver.times(), "balance");
    const TileCensus local = solver.census();
    measure(solver, local, step);
    const TileCensus census = gather_census(comm_, local);
    next = next_partition(solver, census, forced, step);
  }
  if (next) {
    change(solver, std::move(*next));
    last_change_ = step;
  }
  totals_.seconds += MPI_Wtime() - begin;
}

Balancer::Clock Balancer::read_clock(const Solver& solver) {
  const PhaseTimes& times = solver.times();
  Clock clock;
  for (const char* phase : {"p2g", "g2p", "stress_update", "locate", "judge", "sort"}) clock.particles += times.seconds(phase);
  clock.nodes = times.seconds("grid_update") + times.seconds("exchange") - solver.exchange_wait();
  clock.materials = solver.material_seconds();
  for (const double seconds : clock.materials) clock.particles -= seconds;
  return clock;
}

// What steps have cost since the last look, from the sums over all ranks: a single rank's times also tell who shares its core.
void Balancer::measure(const Solver& solver, const TileCensus& census, GlobalIndex step) {
  const Clock clock = read_clock(solver);
  const auto n_steps = static_cast<double>(step - last_look_);
  const auto n_materials = static_cast<std::size_t>(census.n_materials);
  std::vector<double> sums(4 + 2 * n_materials, 0.0);
  sums[0] = clock.particles - last_clock_.particles;
  sums[1] = clock.nodes - last_clock_.nodes;
  sums[2] = n_steps * static_cast<double>(census.n_particles());
  sums[3] = n_steps * static_cast<double>(census.size() * tile_nodes);
  for (std::size_t m = 0; m < n_materials; ++m) {
    sums[4 + m] = clock.materials[m] - (last_clock_.materials.empty() ? 0.0 : last_clock_.materials[m]);
    for (std::size_t t = 0; t < census.size(); ++t)
      sums[4 + n_materials + m] += n_steps * static_cast<double>(census.count[t * n_materials + m]);
  }
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm_.get()));
  last_clock_ = clock;
  last_look_ = step;
  if (sums[2] == 0.0) return;
  constexpr double nanoseconds = 1e9;
  average_in(cost_.node, nanoseconds * sums[1] / sums[3], !measured_);
  cost_.particle.resize(n_materials, CostModel::default_particle);
  for (std::size_t m = 0; m < n_materials; ++m)
    if (const double n = sums[4 + n_materials + m]; n > 0.0)
      average_in(cost_.particle[m], nanoseconds * (sums[0] / sums[2] + sums[4 + m] / n), !measured_);
  measured_ = true;
}

// The root decides; every rank learns the partition. Nothing where the present one stays.
std::optional<Partition> Balancer::next_partition(const Solver& solver, const TileCensus& census, bool forced,
                                                  GlobalIndex step) {
  std::optional<Partition> next;
  root_guard(comm_, [&] {
    const GridGeometry& grid = solver.physics().grid;
    const Partition& present = solver.partition();
    const TileLoad load = tile_load(census, cost_);
    const double begin = MPI_Wtime();
    if (forced) {
      next = make_partition(grid, settings_, load, comm_.size(), &present, cost_);
      average_in(change_.tile, (MPI_Wtime() - begin) / static_cast<double>(std::max<std::size_t>(load.size(), 1)), false);
      if (next->worker == present.worker && next->nodes == present.nodes) next.reset();
    } else {
      const auto horizon = static_cast<double>(std::max<GlobalIndex>(step - last_change_, settings_.decision_interval));
      next = worthwhile_change(grid, load, present, cost_, change_, horizon);
    }
    if (next) busiest_moves_ = busiest_moves(present, *next, load);
  });
  int changes = next.has_value();
  BULKLEY_MPI(MPI_Bcast(&changes, 1, MPI_INT, 0, comm_.get()));
  if (!changes) return std::nullopt;
  return share_partition(comm_, next ? std::move(*next) : Partition{});
}

void Balancer::change(Solver& solver, Partition partition) {
  const double begin = MPI_Wtime(), rebuilding = solver.times().seconds("rebuild");
  totals_.n_moved += solver.adopt(std::move(partition));
  ++totals_.n_repartitions;
  const double rebuild = solver.times().seconds("rebuild") - rebuilding;
  average_in(change_.rebuild, rebuild, totals_.n_repartitions == 1);
  if (busiest_moves_ > 0)
    average_in(change_.particle, (MPI_Wtime() - begin - rebuild) / static_cast<double>(busiest_moves_), false);
}

}  // namespace bulkley
