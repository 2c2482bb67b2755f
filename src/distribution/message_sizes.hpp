#pragma once
// Who sends how much to whom, where only the senders know.

#include <cstdint>
#include <vector>

#include "distribution/neighbours.hpp"

namespace bulkley {

/// A number of things that go to, or come from, one rank.
struct MessageSize {
  int rank;
  GlobalIndex count;
};

/// Tells each neighbour what comes to it, which may be nothing, and learns the same, by ascending rank. Precondition: `outgoing`, by
/// ascending rank, goes to neighbours alone. Between neighbours.
std::vector<MessageSize> exchange_counts(const Comm& comm, const Neighbours& neighbours,
                                         const std::vector<MessageSize>& outgoing);

/// What `incoming` ranks send, one message after the other, while `sent` goes to `outgoing` ranks in the same way. Counts are of
/// items of so many numbers. Between neighbours.
std::vector<std::int32_t> trade(const Comm& comm, const std::vector<MessageSize>& outgoing,
                                const std::vector<std::int32_t>& sent, const std::vector<MessageSize>& incoming,
                                int numbers_per_item);

}  // namespace bulkley
