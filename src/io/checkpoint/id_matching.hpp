#pragma once
// Particles of two lists, each in any order over the ranks, brought together by id.

#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// A particle of both lists, met on the rank of the hash of its id. Slots count the rows that the rank has received in a round.
struct Match {
  GlobalIndex id;
  LocalIndex slot_a, slot_b;
};

/// One of the lists: which of its rows a rank sends where in which round.
class IdRoutes {
 public:
  /// `ids`: of this rank's rows. Not collective.
  IdRoutes(const Comm& comm, const std::vector<GlobalIndex>& ids, std::size_t n_rounds);

  /// The rows that come to this rank in a round, of `row_bytes` each; `rows`: this rank's. The ranks' rows follow each other in
  /// rank order. Every rank sends to every other. Collective.
  std::vector<std::byte> exchange(const Comm& comm, std::size_t round, const std::byte* rows, std::size_t row_bytes) const;

 private:
  std::size_t n_ranks_;
  std::vector<GlobalIndex> order_;  ///< rows by round and rank
  std::vector<GlobalIndex> begin_;  ///< in `order_`, of each round and rank; and one past the last
};

/// Every id of a list meets the same id of the other. A round moves some `particles_per_round` of a rank, and a rank keeps 8
/// bytes a row and 16 a match beside the ids, and 16 a round for each rank that there is.
class IdMatching {
 public:
  /// Ids of this rank's rows in both lists. Collective.
  IdMatching(const Comm& comm, const std::vector<GlobalIndex>& a, const std::vector<GlobalIndex>& b,
             GlobalIndex particles_per_round);

  std::size_t n_rounds() const { return matches_.size(); }
  const IdRoutes& a() const { return a_; }
  const IdRoutes& b() const { return b_; }
  /// Of this rank, by ascending id.
  const std::vector<Match>& matches(std::size_t round) const { return matches_[round]; }

  /// Of all ranks: particles that only one of the lists has, the smallest such id, and the smallest that a list has twice; -1:
  /// none.
  struct Rest {
    GlobalIndex n_only = 0, first_only = -1, twice = -1;
  };
  const Rest& rest_a() const { return rest_a_; }
  const Rest& rest_b() const { return rest_b_; }

 private:
  void match(const Comm& comm, std::size_t round, const std::vector<GlobalIndex>& a, const std::vector<GlobalIndex>& b);

  std::vector<std::vector<Match>> matches_;  ///< of each round
  IdRoutes a_, b_;
  Rest rest_a_, rest_b_;
};

}  // namespace bulkley
