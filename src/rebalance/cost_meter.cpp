#include "rebalance/cost_meter.hpp"

#include <algorithm>
#include <utility>

#include "integrator/solver.hpp"

namespace bulkley {

namespace {

// A running mean, which single noisy measurements hardly move: sometimes one takes very long for reasons that have nothing
// to do with what is measured.
void average_in(double& mean, double value) {
  constexpr double newest_weight = 0.25;
  mean += newest_weight * (std::min(value, 2.0 * mean) - mean);
}

}  // namespace

CostMeter::CostMeter(CostModel steps, CostSource source)
    : source_(source), steps_(std::move(steps)), has_steps_(!steps_.particle.empty()) {}

CostMeter::Clock CostMeter::read_clock(const Solver& solver) {
  const PhaseTimes& times = solver.times();
  Clock clock;
  // The pressure's cells are where particles are. It includes waits for other ranks, which weigh particles the more.
  for (const Phase phase : {Phase::p2g, Phase::viscosity, Phase::pressure, Phase::g2p, Phase::stress_update, Phase::locate,
                            Phase::judge, Phase::sort})
    clock.particles += times[phase].seconds;
  clock.nodes = times[Phase::grid_update].seconds + times[Phase::exchange].seconds - solver.exchange_wait();
  clock.materials = solver.material_seconds();
  for (const double seconds : clock.materials) clock.particles -= seconds;
  return clock;
}

// From the sums over all ranks: a single rank's times also tell who shares its core.
void CostMeter::after_steps(const Comm& comm, const Solver& solver, const TileCensus& census, GlobalIndex n_steps) {
  if (source_ == CostSource::given) return;
  const Clock clock = read_clock(solver);
  const auto steps = static_cast<double>(n_steps);
  const auto n_materials = static_cast<std::size_t>(census.n_materials);
  std::vector<double> sums(4 + 2 * n_materials, 0.0);
  sums[0] = clock.particles - last_.particles;
  sums[1] = clock.nodes - last_.nodes;
  sums[2] = steps * static_cast<double>(census.n_particles());
  sums[3] = steps * static_cast<double>(census.size() * tile_nodes);
  for (std::size_t m = 0; m < n_materials; ++m) {
    sums[4 + m] = clock.materials[m] - (last_.materials.empty() ? 0.0 : last_.materials[m]);
    for (std::size_t t = 0; t < census.size(); ++t)
      sums[4 + n_materials + m] += steps * static_cast<double>(census.count[t * n_materials + m]);
  }
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm.get()));
  last_ = clock;
  if (sums[2] == 0.0) return;
  constexpr double nanoseconds = 1e9;
  const auto learn = [this](double& mean, double value) { has_steps_ ? average_in(mean, value) : void(mean = value); };
  learn(steps_.node, nanoseconds * sums[1] / sums[3]);
  steps_.particle.resize(n_materials, CostModel::default_particle);
  for (std::size_t m = 0; m < n_materials; ++m)
    if (const double n = sums[4 + n_materials + m]; n > 0.0)
      learn(steps_.particle[m], nanoseconds * (sums[0] / sums[2] + sums[4 + m] / n));
  has_steps_ = true;
}

void CostMeter::after_check(double seconds) {
  if (source_ == CostSource::clock) average_in(check_, seconds);
}

void CostMeter::after_whole_map(double seconds) {
  if (source_ == CostSource::clock) average_in(change_.tile, seconds);
}

void CostMeter::after_change(double seconds, double rebuild, GlobalIndex busiest_moves) {
  if (source_ == CostSource::given) return;
  has_change_ ? average_in(change_.rebuild, rebuild) : void(change_.rebuild = rebuild);
  has_change_ = true;
  if (busiest_moves > 0) average_in(change_.particle, (seconds - rebuild) / static_cast<double>(busiest_moves));
}

}  // namespace bulkley
