#include "distribution/neighbours.hpp"

#include <algorithm>

#include "distribution/rank_messages.hpp"

namespace bulkley {

bool Neighbours::has(int rank) const { return std::binary_search(ranks_.begin(), ranks_.end(), rank); }

void Neighbours::introduce(std::span<const int> others) {
  std::vector<int> found(others.begin(), others.end());
  std::erase_if(found, [&](int rank) { return rank == comm_->rank() || has(rank); });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<RankMessage> introductions;
  for (const int rank : found) introductions.push_back({rank, {}});
  for (const RankMessage& from : sparse_exchange(*comm_, introductions)) found.push_back(from.rank);
  ranks_.insert(ranks_.end(), found.begin(), found.end());
  std::sort(ranks_.begin(), ranks_.end());
  ranks_.erase(std::unique(ranks_.begin(), ranks_.end()), ranks_.end());
}

void Neighbours::forget() {
  ranks_.clear();
  ++generation_;
}

}  // namespace bulkley
