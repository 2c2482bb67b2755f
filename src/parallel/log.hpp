#pragma once
// What a run says while it runs: lines from the root, warnings merged over ranks, and the wall time of named phases.

#include <petsclog.h>

#include <string>
#include <string_view>
#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// Prints one line to stdout on the root and flushes, so that batch logs are current. Not collective.
void log_line(const Comm& comm, std::string_view text);

/// Collects warnings on each rank until print() shows each distinct text once, with the number of times and ranks.
class Warnings {
 public:
  /// Not collective.
  void add(std::string text);
  /// Prints to stderr on the root, in alphabetical order, and forgets. Collective.
  void print(const Comm& comm);

 private:
  struct Entry {
    std::string text;
    GlobalIndex count;
  };
  std::vector<Entry> entries_;
};

/// Wall time of one rank in each named phase, in the order of first use.
struct PhaseTimes {
  struct Entry {
    std::string name;
    double seconds = 0.0;
    GlobalIndex n_calls = 0;
    PetscLogEvent event = -1;  ///< of the same name in PETSc's -log_view
  };
  std::vector<Entry> entries;

  /// Seconds so far in the phase, 0 if it never ran.
  double seconds(std::string_view name) const;
  GlobalIndex n_calls(std::string_view name) const;
};

/// From construction to destruction, this rank is in phase `name`: adds to `times` and to PETSc's event of that name.
/// Phases of one PhaseTimes may nest; the outer one includes the inner. Not collective.
class Phase {
 public:
  Phase(PhaseTimes& times, std::string_view name);
  ~Phase();
  Phase(const Phase&) = delete;
  Phase& operator=(const Phase&) = delete;

 private:
  PhaseTimes& times_;
  std::size_t index_;
  double start_;
};

/// One phase over all ranks, s.
struct PhaseSummary {
  std::string name;
  GlobalIndex n_calls = 0;  ///< of this rank
  double smallest = 0.0, mean = 0.0, largest = 0.0;
};

/// Smallest, mean and largest time over the ranks of every phase that any rank ran; a rank that did not run it spent no time
/// in it. Collective.
std::vector<PhaseSummary> summarize(const Comm& comm, const PhaseTimes& times);

}  // namespace bulkley
