#pragma once
// The ranks that a rank exchanges particles and nodes with.

#include <cstdint>
#include <span>
#include <vector>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// Neighbours of this rank. They are mutual: of two ranks, each is a neighbour of the other or neither is. So both know that a
/// message is due, and no step has to ask all ranks who sends to whom.
class Neighbours {
 public:
  /// None. `comm` must outlive this. Not collective.
  explicit Neighbours(const Comm& comm) : comm_(&comm) {}

  /// Ascending, without this rank.
  std::span<const int> ranks() const { return ranks_; }
  bool has(int rank) const;
  /// A number that ranks compare to see that they agree on the map that their neighbours follow from: of calls of `forget`.
  std::int64_t generation() const { return generation_; }

  /// Makes this rank and each of `others` neighbours; those that are, and this rank itself, may be among them, in any order and
  /// more than once. A message to each new one and two barriers (sparse_exchange). Collective.
  void introduce(std::span<const int> others);
  /// No neighbours any more. Every rank must call it at the same point. Not collective.
  void forget();

 private:
  const Comm* comm_;
  std::vector<int> ranks_;
  std::int64_t generation_ = 0;
};

}  // namespace bulkley
