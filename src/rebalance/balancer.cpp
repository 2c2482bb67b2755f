#include "rebalance/balancer.hpp"

#include <algorithm>
#include <array>

#include "integrator/solver.hpp"

namespace bulkley {

namespace {

constexpr GlobalIndex first_check = 10;  // steps after the start
constexpr double asked_growth = 1.2;     // of the most loaded rank since the last check, in scenes with inflows
constexpr double check_share = 0.01;     // of the time that checks may take which no growth of the imbalance asks for

}  // namespace

Balancer::Balancer(const Comm& comm, const PartitionSettings& settings, CostMeter costs, GlobalIndex step)
    : Balancer(comm, settings, std::move(costs), step, make_partitioner(comm, settings)) {}

Balancer::Balancer(const Comm& comm, const PartitionSettings& settings, CostMeter costs, GlobalIndex step,
                   std::unique_ptr<Partitioner> partitioner)
    : comm_(comm),
      settings_(settings),
      costs_(std::move(costs)),
      partitioner_(std::move(partitioner)),
      last_check_(step),
      last_change_(step) {}

void Balancer::after_step(Solver& solver, GlobalIndex step) {
  if (comm_.size() == 1) return;
  const bool forced = settings_.remake_interval > 0 && step % settings_.remake_interval == 0;
  const bool follows = settings_.method == PartitionMethod::automatic || settings_.method == PartitionMethod::bisection;
  if (!forced && !(follows && check_is_due(solver, step))) return;

  const double begin = MPI_Wtime();
  PartitionProposal proposal;
  Decision decision;
  {
    const PhaseTimer timer(solver.times(), Phase::balance);
    const TileCensus census = solver.census();
    costs_.after_steps(comm_, solver, census, step - last_check_);
    last_check_ = step;
    proposal = check(solver, census, forced, step);
    decision = next_check(census);
  }
  costs_.after_check(MPI_Wtime() - begin);
  share_at_check_ = solver.bounds().transport.largest_share;
  const bool changes = proposal.partition.has_value();
  if (changes) {
    change(solver, std::move(*proposal.partition), proposal.busiest_moves);
    last_change_ = step;
  }
  // Where a change did not pay yet, the next check comes when a quarter more imbalance has accumulated.
  check_interval_ = decision.interval;
  imbalance_budget_ =
      std::max(decision.budget, changes ? GlobalIndex{0} : accumulated_imbalance_ + accumulated_imbalance_ / 4);
  if (changes) {
    reference_share_ = solver.bounds().transport.largest_share;
    accumulated_imbalance_ = 0;
  }
  totals_.seconds += MPI_Wtime() - begin;
}

// Decided by every rank for itself, from what all know alike: the most loaded rank's share rides on the all-reduce of each
// step. A check is due when the growth of that share has cost as much time as a check and a change cost (Menon et al. 2012),
// and from time to time in any case, as long as that costs little.
bool Balancer::check_is_due(const Solver& solver, GlobalIndex step) {
  if (settings_.decision_interval == 0) return false;
  const StepBounds& bounds = solver.bounds();
  if (reference_share_ < 0) {  // a first check soon, to measure
    if (step - last_check_ < first_check) return false;
    reference_share_ =
        static_cast<GlobalIndex>(target_imbalance * static_cast<double>(bounds.totals.n_particles) / comm_.size());
    return true;
  }
  // Inflows add particles to few ranks, and little imbalance accumulates while there are few.
  if (!solver.physics().feeds.empty() &&
      static_cast<double>(bounds.transport.largest_share) > asked_growth * static_cast<double>(share_at_check_))
    return true;
  accumulated_imbalance_ += std::max<GlobalIndex>(0, bounds.transport.largest_share - reference_share_);
  return accumulated_imbalance_ > imbalance_budget_ || step - last_check_ >= check_interval_;
}

// Asks the partitioner.
PartitionProposal Balancer::check(const Solver& solver, const TileCensus& census, bool forced, GlobalIndex step) {
  PartitionRequest request{solver.physics().grid, census, costs_.steps(), &solver.partition(), {}, costs_.change()};
  if (!forced) request.horizon = static_cast<double>(step - last_change_);
  PartitionProposal proposal = partitioner_->propose(comm_, request);
  if (proposal.tile_seconds > 0.0) costs_.after_whole_map(proposal.tile_seconds);
  if (!has_warned_ && !proposal.notes.warnings.empty()) {
    warning_ = proposal.notes.warnings.front();
    has_warned_ = true;
  }
  return proposal;
}

// By the root's measurements: those of ranks differ.
Balancer::Decision Balancer::next_check(const TileCensus& census) const {
  std::array<GlobalIndex, 2> sums{tile_load(census, costs_.steps()).total(), census.n_particles()};
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_INT64_T, MPI_SUM, comm_.get()));
  const auto [load, n_particles] = sums;
  Decision decision{0, settings_.decision_interval};
  if (load > 0) {
    const double particle = 1e-12 * static_cast<double>(load) / static_cast<double>(n_particles);
    decision.budget = static_cast<GlobalIndex>((costs_.check() + costs_.change().rebuild) / particle);
    const double mean_step = 1e-12 * static_cast<double>(load) / comm_.size();
    decision.interval = std::max(decision.interval, static_cast<GlobalIndex>(costs_.check() / (check_share * mean_step)));
  }
  static_assert(sizeof(Decision) == 2 * sizeof(GlobalIndex));
  BULKLEY_MPI(MPI_Bcast(&decision, 2, MPI_INT64_T, 0, comm_.get()));
  return decision;
}

void Balancer::change(Solver& solver, Partition partition, GlobalIndex busiest_moves) {
  const double begin = MPI_Wtime(), rebuilding = solver.times()[Phase::rebuild].seconds;
  totals_.n_moved += solver.adopt(std::move(partition));
  ++totals_.n_repartitions;
  costs_.after_change(MPI_Wtime() - begin, solver.times()[Phase::rebuild].seconds - rebuilding, busiest_moves);
}

}  // namespace bulkley
