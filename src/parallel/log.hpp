#pragma once
// What a run says while it runs: lines from the root, and warnings merged over ranks.

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

}  // namespace bulkley
