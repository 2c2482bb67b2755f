#pragma once
// The real step on a scene of the bench, and its comparison with other variants.

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/scene.hpp"
#include "integrator/solver.hpp"

namespace bulkley {

/// Steps of one timed block.
inline constexpr int block_steps = 16;

/// A solver on its way through a scene of the bench.
class BenchRun {
 public:
  /// Seeds the scene and takes one block of steps, which warms the caches and fills the pool. Collective.
  BenchRun(const Comm& comm, const BenchCase& what);

  /// Takes `n_steps` steps; wall time of one, s, on the slowest rank. Collective.
  double advance(int n_steps);

  Solver& solver() { return *solver_; }
  GlobalIndex n_particles() const { return solver_->bounds().totals.n_particles; }
  /// Factor from the wall time of a step, s, to ns per particle, step and rank.
  double scale() const { return 1e9 * comm_.size() / static_cast<double>(n_particles()); }

  /// ns per particle, step and rank of each phase since the first block, mean over ranks. Collective.
  std::vector<std::pair<std::string, double>> phases() const;
  /// Physical sorts per step since the first block.
  double sorts_per_step() const;
  /// Part of the particles that flowed in the last step. Collective.
  double yielded_fraction() const;
  /// Of conjugate gradients, a step since the first block.
  double iterations_per_step() const { return static_cast<double>(n_iterations_) / static_cast<double>(n_steps_); }
  double rounds_per_step() const { return static_cast<double>(n_rounds_) / static_cast<double>(n_steps_); }
  /// Largest speed at the start over the wave speed at rest, that of the material's own bulk modulus.
  double mach_number() const { return mach_number_; }

 private:
  const Comm& comm_;
  std::unique_ptr<Solver> solver_;
  TimeStepState state_;
  double time_ = 0.0;  ///< s
  double mach_number_ = 0.0;
  GlobalIndex n_steps_ = 0;  ///< timed
  GlobalIndex n_iterations_ = 0, n_rounds_ = 0;
};

/// A variant's block: gives the wall time of one of its steps, s. Collective.
using Block = std::function<double()>;

/// Runs the blocks in turn, `n_rounds` times, so that all see the same machine; their results by block and round.
/// Collective.
std::vector<std::vector<double>> time_in_turn(int n_rounds, const std::vector<Block>& blocks);

/// Of the rounds of one variant. Sorts and rebuilds come irregularly: a median would count them too often or not at all.
double mean(const std::vector<double>& values);

/// Runs `work` on the root while the other ranks sleep, so that they take no part of the machine; its result on the root.
/// Collective; throws what `work` throws, on every rank.
double on_root_alone(const Comm& comm, const Block& work);

/// What one case costs. What was not measured is NaN.
struct BenchResult {
  static constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
  GlobalIndex n_particles = 0;
  int n_ranks = 1;
  double ns = undefined;        ///< per particle, step and rank; mean of blocks
  double naive_ns = undefined;  ///< per particle and step of the naive kernel
  double ratio_to_naive = undefined;
  double one_rank_ns = undefined;       ///< of one rank with all particles
  double throughput_ratio = undefined;  ///< particles per second over those of one rank
  std::vector<std::pair<std::string, double>> phases;
  double sorts_per_step = undefined;
  double nodes_per_particle = undefined;  ///< grid nodes that particles reach, over all ranks
  double yielded_fraction = undefined;
  double mach_number = undefined;
  double bytes_per_particle = undefined;           ///< that all ranks came to occupy beyond the empty program
  double forecast_bytes_per_particle = undefined;  ///< the same predicted from the scene alone
  // Integrator imex.
  double explicit_ns = undefined;                   ///< of the explicit step of the material's own bulk modulus, in turn
  double ratio_to_explicit = undefined;             ///< cost of a step over that of the explicit one
  double iterations_per_step = undefined;           ///< of the pressure system
  double rounds_per_step = undefined;               ///< its solutions, until walls and free surfaces keep their state
  double exchange_bytes_per_iteration = undefined;  ///< that the busiest rank sends
  double exchange_bytes_per_step = undefined;       ///< that the busiest rank sends
  GlobalIndex exchange_messages_per_step = 0;       ///< likewise
};

/// What to time in addition to the real step.
struct BenchEffort {
  int n_steps = 5 * block_steps;  ///< in blocks of block_steps
  bool naive = true;              ///< the naive kernel, on the root
  bool one_rank = true;           ///< the same scene on the root alone, if there are several ranks and it has the memory
};

/// Times one case. Collective; throws UsageError.
BenchResult run_bench(const Comm& comm, const BenchCase& what, const BenchEffort& effort);

}  // namespace bulkley
