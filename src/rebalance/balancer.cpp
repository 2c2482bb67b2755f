#include "rebalance/balancer.hpp"

#include <algorithm>

#include "balance/traffic.hpp"
#include "integrator/solver.hpp"
#include "rebalance/share.hpp"

namespace bulkley {

namespace {

constexpr double least_gain = 0.02;     // of the time of a step
constexpr GlobalIndex first_look = 10;  // steps after the start
constexpr double look_share = 0.01;     // of the time that looks without need may take

// Of a new measurement in the running mean; single ones are noisy.
constexpr double newest_weight = 0.25;

// Particles that the busiest rank sends or receives in going from one map to the other.
GlobalIndex busiest_moves(const Partition& from, const Partition& to, const TileLoad& load) {
  std::vector<GlobalIndex> of_rank(static_cast<std::size_t>(from.n_ranks), 0);
  for (std::size_t t = 0; t < load.size(); ++t) {
    const auto tile = static_cast<std::size_t>(load.tile[t]);
    if (from.worker[tile] == to.worker[tile]) continue;
    of_rank[static_cast<std::size_t>(from.worker[tile])] += load.count[t];
    of_rank[static_cast<std::size_t>(to.worker[tile])] += load.count[t];
  }
  return *std::max_element(of_rank.begin(), of_rank.end());
}

// Now and then something takes very long that has nothing to do with what is measured.
void average_in(double& mean, double value, bool first) {
  mean = first ? value : mean + newest_weight * (std::min(value, 2.0 * mean) - mean);
}

}  // namespace

Change worthwhile_change(const GridGeometry& grid, const TileLoad& load, const Partition& present, const CostModel& cost,
                         const ChangeCost& change, double horizon, double fresh_exchange) {
  const std::vector<RankTraffic> traffic = predict_traffic(grid, present, load);
  const double now = predicted_step(traffic, cost);
  const double mean = 1e-12 * static_cast<double>(load.total()) / present.n_ranks;
  // Tiles are not divided: with few of them for each rank the heaviest is the limit, not the mean.
  const GlobalIndex heaviest = load.size() > 0 ? *std::max_element(load.weight.begin(), load.weight.end()) : 0;
  const double reachable = std::max(even_enough * mean, 1e-12 * static_cast<double>(heaviest)) + fresh_exchange;
  if (now - reachable < least_gain * now || (now - reachable) * horizon <= change.rebuild) return {};

  struct Candidate {
    Partition partition;
    double step, net;  // s: of a step; saved over the horizon less the cost
  };
  const auto judged = [&](Partition partition, double making) {
    const double step = predicted_step(predict_traffic(grid, partition, load), cost);
    const double moving = change.particle * static_cast<double>(busiest_moves(present, partition, load));
    return Candidate{std::move(partition), step, (now - step) * horizon - making - change.rebuild - moving};
  };
  auto [handed_on, straight] = rebalanced(grid, load, present);
  Candidate best = judged(std::move(handed_on), 0.0);
  if (Candidate other = judged(std::move(straight), 0.0); other.net > best.net) best = std::move(other);

  Change result;
  const double making = change.tile * static_cast<double>(load.size());
  const bool more_to_gain = best.step - reachable > least_gain * now;
  if (more_to_gain && (now - reachable) * horizon - making - change.rebuild > std::max(best.net, 0.0)) {
    const double begin = MPI_Wtime();
    Candidate whole =
        judged(make_partition(grid, {PartitionMethod::automatic}, load, present.n_ranks, &present, cost), making);
    result.making = MPI_Wtime() - begin;
    result.whole = whole.net > best.net;
    if (result.whole) best = std::move(whole);
  }
  if (best.net > 0.0 && now - best.step >= least_gain * now) result.partition = std::move(best.partition);
  return result;
}

Balancer::Balancer(const Comm& comm, const PartitionSettings& settings, CostModel cost, GlobalIndex step)
    : comm_(comm), settings_(settings), cost_(std::move(cost)), last_look_(step), last_change_(step) {
  measured_ = !cost_.particle.empty();
}

void Balancer::after_step(Solver& solver, GlobalIndex step) {
  if (comm_.size() == 1) return;
  const bool forced = settings_.remake_interval > 0 && step % settings_.remake_interval == 0;
  if (!forced && !(settings_.method == PartitionMethod::automatic && due(solver, step))) return;

  const double begin = MPI_Wtime();
  std::optional<Partition> next;
  Verdict verdict;
  {
    const PhaseTimer timer(solver.times(), Phase::balance);
    const TileCensus local = solver.census();
    measure(solver, local, step);
    verdict = decide(solver, gather_census(comm_, local), forced, step, next);
    if (verdict.changes) next = share_partition(comm_, next ? std::move(*next) : Partition{});
  }
  average_in(change_.look, MPI_Wtime() - begin, false);
  if (verdict.changes) {
    change(solver, std::move(*next), verdict.busiest_moves);
    last_change_ = step;
  }
  // Where it did not pay yet, another look comes when a quarter more has been lost.
  pause_ = verdict.pause;
  patience_ = std::max(verdict.patience, verdict.changes ? GlobalIndex{0} : lost_ + lost_ / 4);
  if (verdict.changes) {
    share_then_ = solver.bounds().transport.largest_share;
    lost_ = 0;
  }
  totals_.seconds += MPI_Wtime() - begin;
}

// Whether the root should look at the balance. Decided by every rank for itself, from what all know alike: the fullest
// rank's share rides on the all-reduce of each step. It is time when as much has been lost to its growth as a look and a
// change cost (Menon et al. 2012), and now and then in any case, as long as that costs little.
bool Balancer::due(const Solver& solver, GlobalIndex step) {
  if (settings_.decision_interval == 0) return false;
  const StepBounds& bounds = solver.bounds();
  if (share_then_ < 0) {  // a first look soon, to measure
    if (step - last_look_ < first_look) return false;
    share_then_ = static_cast<GlobalIndex>(even_enough * static_cast<double>(bounds.totals.n_particles) / comm_.size());
    return true;
  }
  lost_ += std::max<GlobalIndex>(0, bounds.transport.largest_share - share_then_);
  return lost_ > patience_ || step - last_look_ >= pause_;
}

Balancer::Clock Balancer::read_clock(const Solver& solver) {
  const PhaseTimes& times = solver.times();
  Clock clock;
  for (const Phase phase : {Phase::p2g, Phase::g2p, Phase::stress_update, Phase::locate, Phase::judge, Phase::sort})
    clock.particles += times[phase].seconds;
  clock.nodes = times[Phase::grid_update].seconds + times[Phase::exchange].seconds - solver.exchange_wait();
  clock.materials = solver.material_seconds();
  for (const double seconds : clock.materials) clock.particles -= seconds;
  return clock;
}

// What steps have cost since the last look, from the sums over all ranks: a single rank's times also tell who shares its
// core.
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

// The root decides, `next` is its alone.
Balancer::Verdict Balancer::decide(const Solver& solver, const TileCensus& census, bool forced, GlobalIndex step,
                                   std::optional<Partition>& next) {
  Verdict verdict;
  root_guard(comm_, [&] {
    const GridGeometry& grid = solver.physics().grid;
    const Partition& present = solver.partition();
    const TileLoad load = tile_load(census, cost_);
    const auto exchange_of = [&](const Partition& p) { return predicted_exchange(predict_traffic(grid, p, load), cost_); };
    if (forced) {
      PartitionNotes notes;
      next = make_partition(grid, settings_, load, comm_.size(), &present, cost_, &notes);
      if (!has_warned_ && !notes.warnings.empty()) {
        warning_ = notes.warnings.front();
        has_warned_ = true;
      }
      if (next->worker == present.worker && next->boxes == present.boxes) next.reset();
    } else {
      if (fresh_exchange_ < 0.0) fresh_exchange_ = exchange_of(present);
      Change found =
          worthwhile_change(grid, load, present, cost_, change_, static_cast<double>(step - last_change_), fresh_exchange_);
      if (found.making > 0.0) average_in(change_.tile, found.making / static_cast<double>(load.size()), false);
      next = std::move(found.partition);
      if (next && found.whole) fresh_exchange_ = exchange_of(*next);
    }
    verdict.changes = next.has_value();
    verdict.pause = settings_.decision_interval;
    if (load.size() == 0) return;
    if (next) verdict.busiest_moves = busiest_moves(present, *next, load);
    const double particle = 1e-12 * static_cast<double>(load.total()) / static_cast<double>(census.n_particles());
    verdict.patience = static_cast<GlobalIndex>((change_.look + change_.rebuild) / particle);
    const double mean_step = 1e-12 * static_cast<double>(load.total()) / comm_.size();
    verdict.pause = std::max<GlobalIndex>(settings_.decision_interval,
                                          static_cast<GlobalIndex>(change_.look / (look_share * mean_step)));
  });
  static_assert(sizeof(Verdict) == 4 * sizeof(GlobalIndex));
  BULKLEY_MPI(MPI_Bcast(&verdict, 4, MPI_INT64_T, 0, comm_.get()));
  return verdict;
}

void Balancer::change(Solver& solver, Partition partition, GlobalIndex busiest_moves) {
  const double begin = MPI_Wtime(), rebuilding = solver.times()[Phase::rebuild].seconds;
  totals_.n_moved += solver.adopt(std::move(partition));
  ++totals_.n_repartitions;
  const double rebuild = solver.times()[Phase::rebuild].seconds - rebuilding;
  average_in(change_.rebuild, rebuild, totals_.n_repartitions == 1);
  if (busiest_moves > 0)
    average_in(change_.particle, (MPI_Wtime() - begin - rebuild) / static_cast<double>(busiest_moves), false);
}

}  // namespace bulkley
