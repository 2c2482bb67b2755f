#pragma once
// Lists of numbers between ranks: to those that expect them and to those that do not.

#include <cstdint>
#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// Numbers that go to, or came from, one rank.
struct RankMessage {
  int rank;
  std::vector<std::int64_t> words;
};

/// Sends each message, of which each rank gets one at most from each other, and returns those that came, by ascending rank. As many
/// messages as there are and two barriers, whatever the number of ranks (Hoefler, Siebert, Lumsdaine 2010). Collective.
std::vector<RankMessage> sparse_exchange(const Comm& comm, const std::vector<RankMessage>& sent);

/// Sends `sent` and fills `received`, whose ranks and sizes say what is to come. Between the ranks named.
void exchange_messages(const Comm& comm, int tag, const std::vector<RankMessage>& sent, std::vector<RankMessage>& received);

}  // namespace bulkley
