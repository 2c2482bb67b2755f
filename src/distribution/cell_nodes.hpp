#pragma once
// Of the nodes of a CellGrid, those that take part in a step: a thin film fills less than half of the nodes of its tiles.

#include <span>
#include <vector>

#include "distribution/cell_grid.hpp"

namespace bulkley {

/// Nodes that take part go by numbers of their own, which ascend with those of the CellGrid. Rows of stencils of which all nodes take
/// part stay in one piece.
class CellNodes {
 public:
  /// Those of `grid` where `takes_part`, by number there, is not 0. Not collective.
  void select(const CellGrid& grid, std::span<const char> takes_part);
  /// All of so many nodes, by the numbers that they have. Not collective.
  void select_all(LocalIndex n_nodes);

  LocalIndex size() const { return before_.back(); }
  /// Of a node of the CellGrid; -1: it takes no part.
  LocalIndex number(LocalIndex node) const {
    const auto n = static_cast<std::size_t>(node);
    return before_[n] < before_[n + 1] ? before_[n] : -1;
  }
  /// How many of the nodes before that one, or the end, take part.
  LocalIndex number_before(LocalIndex node) const { return before_[static_cast<std::size_t>(node)]; }

  /// Of those, as of the CellGrid.
  std::span<const LocalIndex> complete() const { return complete_; }
  std::span<const CellGrid::Copy> owned() const { return owned_; }
  std::span<const CellGrid::Copy> in_pool() const { return in_pool_; }

  std::size_t memory() const;

 private:
  std::vector<LocalIndex> before_{0}, complete_;
  std::vector<CellGrid::Copy> owned_, in_pool_;
};

}  // namespace bulkley
