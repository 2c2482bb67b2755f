#pragma once
// Wall time of the phases of a step: on this rank, and over all ranks.

#include <array>
#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// What a rank can be busy with. The cost model, the balancer and the reports read times by these, so that a phase cannot be
/// renamed in one place only.
enum class Phase : int {
  p2g,
  exchange,
  forces,  ///< of a magnetic field: solution, and what particles give to nodes
  grid_update,
  viscosity,  ///< implicit
  pressure,   ///< implicit
  judge,      ///< of a trial step, before a particle changes
  g2p,
  stress_update,
  locate,
  migrate,
  reduce,
  rebuild,
  sort,
  balance,
};
inline constexpr int n_phases = static_cast<int>(Phase::balance) + 1;

/// As status.json, the summary of a run and PETSc's -log_view call it.
const char* name(Phase phase);

/// Wall time of one rank in each phase.
struct PhaseTimes {
  struct Entry {
    double seconds = 0.0;
    GlobalIndex n_calls = 0;
  };
  std::array<Entry, n_phases> entries{};
  int current = -1;  ///< the phase that this rank is in now, -1: none; read by current_phase

  Entry& operator[](Phase phase) { return entries[static_cast<std::size_t>(phase)]; }
  const Entry& operator[](Phase phase) const { return entries[static_cast<std::size_t>(phase)]; }
};

/// The phase that this rank is in, of nested ones the inner; "output" outside them. Any thread may ask. Not collective.
const char* current_phase(const PhaseTimes& times);

/// From construction to destruction, this rank is in a phase: adds to `times` and to PETSc's event of that name. Phases of
/// one PhaseTimes may nest; the outer one includes the inner. Not collective.
class PhaseTimer {
 public:
  PhaseTimer(PhaseTimes& times, Phase phase);
  ~PhaseTimer();
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  PhaseTimes& times_;
  Phase phase_;
  int outer_;  ///< the phase around this one
  double start_;
};

/// One phase over all ranks, s.
struct PhaseSummary {
  std::string name;
  GlobalIndex n_calls = 0;  ///< the largest of a rank
  double smallest = 0.0, mean = 0.0, largest = 0.0;
};

/// Smallest, mean and largest time over the ranks of every phase that any rank ran, in the order of Phase; a rank that did
/// not run it spent no time in it. The same on every rank. Collective.
std::vector<PhaseSummary> summarize(const Comm& comm, const PhaseTimes& times);

}  // namespace bulkley
