#pragma once
// What a run says while it runs: lines from the root.

#include <string_view>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// Prints one line to stdout on the root and flushes, so that batch logs are current. Not collective.
void log_line(const Comm& comm, std::string_view text);

}  // namespace bulkley
