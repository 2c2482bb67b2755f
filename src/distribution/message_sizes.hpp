#pragma once
// Who sends how much to whom, where only the senders know.

#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// A number of things that go to, or come from, one rank.
struct MessageSize {
  int rank;
  GlobalIndex count;
};

/// Tells each rank what comes to it, and learns the same, by ascending rank; one non-blocking barrier when there is nothing.
/// Collective.
std::vector<MessageSize> exchange_counts(const Comm& comm, const std::vector<MessageSize>& outgoing);

}  // namespace bulkley
