#pragma once
// `bulkley bench --suite`: every number with a bound, and its bound.

#include <string>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "io/files/json_text.hpp"

namespace bulkley {

struct SuiteSettings {
  bool small = false;              ///< a tenth of the particles, for a test
  std::vector<std::string> parts;  ///< of suite_parts; empty: all
};

/// The parts of the suite: floor, cases, sizes, domain, memory, ranks, cores, imex, field.
const std::vector<std::string>& suite_parts();

/// Measures and prints row by row; the figures as JSON. Throws UsageError on several ranks. Collective.
Json run_suite(const Comm& comm, const SuiteSettings& settings);

}  // namespace bulkley
