#pragma once
// Who sends how much to whom, where only the senders know.

#include <vector>

#include "bulkley/base/parallel.hpp"

namespace bulkley {

/// A number of things that go to, or come from, one rank.
struct Parcel {
  int rank;
  GlobalIndex count;
};

/// Tells each rank what comes to it, and learns the same, by ascending rank; one non-blocking barrier when there is nothing.
/// Collective.
std::vector<Parcel> announce(const Comm& comm, const std::vector<Parcel>& outgoing);

}  // namespace bulkley
