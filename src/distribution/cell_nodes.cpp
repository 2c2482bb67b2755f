#include "distribution/cell_nodes.hpp"

#include <numeric>

namespace bulkley {

void CellNodes::select(const CellGrid& grid, std::span<const char> takes_part) {
  before_.resize(static_cast<std::size_t>(grid.n_nodes()) + 1);
  LocalIndex n = 0;
  for (std::size_t node = 0; node + 1 < before_.size(); ++node) {
    before_[node] = n;
    n += takes_part[node] != 0;
  }
  before_.back() = n;
  complete_.clear();
  for (const LocalIndex node : grid.complete_nodes())
    if (number(node) >= 0) complete_.push_back(number(node));
  const auto copy = [&](std::span<const CellGrid::Copy> from, std::vector<CellGrid::Copy>& to) {
    to.clear();
    for (const CellGrid::Copy& pair : from)
      if (number(pair.node) >= 0) to.push_back({number(pair.node), pair.other});
  };
  copy(grid.owned(), owned_);
  copy(grid.in_pool(), in_pool_);
}

void CellNodes::select_all(LocalIndex n_nodes) {
  before_.resize(static_cast<std::size_t>(n_nodes) + 1);
  std::iota(before_.begin(), before_.end(), 0);
}

std::size_t CellNodes::memory() const {
  return (before_.capacity() + complete_.capacity()) * sizeof(LocalIndex) +
         (owned_.capacity() + in_pool_.capacity()) * sizeof(CellGrid::Copy);
}

}  // namespace bulkley
