#include "parallel/phases.hpp"

#include <petsclog.h>

#include <atomic>

#include "bulkley/parallel/petsc.hpp"

namespace bulkley {

namespace {

constexpr std::array<const char*, n_phases> names = {"p2g",      "exchange", "forces",  "grid_update",   "viscosity",
                                                     "pressure", "judge",    "g2p",     "stress_update", "locate",
                                                     "migrate",  "reduce",   "rebuild", "sort",          "balance"};

// PETSc's events of all phases, registered at the first use.
PetscLogEvent event_of(Phase phase) {
  static const auto events = [] {
    PetscClassId class_id = 0;
    BULKLEY_PETSC(PetscClassIdRegister("Bulkley", &class_id));
    std::array<PetscLogEvent, n_phases> registered{};
    for (std::size_t p = 0; p < names.size(); ++p) BULKLEY_PETSC(PetscLogEventRegister(names[p], class_id, &registered[p]));
    return registered;
  }();
  return events[static_cast<std::size_t>(phase)];
}

}  // namespace

const char* name(Phase phase) { return names[static_cast<std::size_t>(phase)]; }

const char* current_phase(const PhaseTimes& times) {
  const int current = std::atomic_ref<int>(const_cast<int&>(times.current)).load(std::memory_order_relaxed);
  return current < 0 ? "output" : names[static_cast<std::size_t>(current)];
}

PhaseTimer::PhaseTimer(PhaseTimes& times, Phase phase) : times_(times), phase_(phase) {
  outer_ = std::atomic_ref<int>(times_.current).exchange(static_cast<int>(phase), std::memory_order_relaxed);
  BULKLEY_PETSC(PetscLogEventBegin(event_of(phase_), 0, 0, 0, 0));
  start_ = MPI_Wtime();
}

PhaseTimer::~PhaseTimer() {
  PhaseTimes::Entry& entry = times_[phase_];
  entry.seconds += MPI_Wtime() - start_;
  ++entry.n_calls;
  std::atomic_ref<int>(times_.current).store(outer_, std::memory_order_relaxed);
  BULKLEY_PETSC(PetscLogEventEnd(event_of(phase_), 0, 0, 0, 0));
}

std::vector<PhaseSummary> summarize(const Comm& comm, const PhaseTimes& times) {
  std::array<double, n_phases> sum{}, smallest{}, largest{};
  std::array<GlobalIndex, n_phases> n_calls{};
  for (std::size_t p = 0; p < sum.size(); ++p) {
    sum[p] = times.entries[p].seconds;
    n_calls[p] = times.entries[p].n_calls;
  }
  BULKLEY_MPI(MPI_Allreduce(sum.data(), smallest.data(), n_phases, MPI_DOUBLE, MPI_MIN, comm.get()));
  BULKLEY_MPI(MPI_Allreduce(sum.data(), largest.data(), n_phases, MPI_DOUBLE, MPI_MAX, comm.get()));
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, sum.data(), n_phases, MPI_DOUBLE, MPI_SUM, comm.get()));
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, n_calls.data(), n_phases, MPI_INT64_T, MPI_MAX, comm.get()));
  std::vector<PhaseSummary> result;
  for (std::size_t p = 0; p < sum.size(); ++p)
    if (n_calls[p] > 0) result.push_back({names[p], n_calls[p], smallest[p], sum[p] / comm.size(), largest[p]});
  return result;
}

}  // namespace bulkley
