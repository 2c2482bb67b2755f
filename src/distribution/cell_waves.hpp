#pragma once
// The order in which products with B^T and then B go through the cells of a CellGrid, so that rows are read from memory once.

#include <span>
#include <vector>

#include "distribution/cell_grid.hpp"

namespace bulkley {

/// Planes of cells, one after the other along x. Once a plane has given its gradients, nodes that no later plane reaches are
/// complete: those of that wave. Cells whose nodes all are complete take their rates in that wave as well, two or three planes
/// behind, while their rows are still near.
class CellWaves {
 public:
  CellWaves() = default;
  /// `joined`: pairs of nodes that need each other to be complete, besides the repeated ones. Not collective.
  CellWaves(const CellGrid& cells, std::span<const CellGrid::Copy> joined);

  /// One wave of so many nodes and no cells. Not collective.
  explicit CellWaves(LocalIndex n_nodes) : n_waves_(1), node_(static_cast<std::size_t>(n_nodes), 0), end_{n_nodes} {}

  LocalIndex size() const { return n_waves_; }
  LocalIndex n_nodes() const { return static_cast<LocalIndex>(node_.size()); }
  /// By place in CellGrid::order().
  std::span<const LocalIndex> planes() const { return plane_; }
  /// In which wave a cell takes its rates, by id.
  LocalIndex of_cell(LocalIndex id) const { return cell_[static_cast<std::size_t>(id)]; }
  LocalIndex of_node(LocalIndex node) const { return node_[static_cast<std::size_t>(node)]; }
  /// The nodes from here on have no part in this wave or those before it.
  LocalIndex end_of_nodes(LocalIndex wave) const { return end_[static_cast<std::size_t>(wave)]; }

  std::size_t memory() const {
    return (plane_.capacity() + cell_.capacity() + node_.capacity() + end_.capacity()) * sizeof(LocalIndex);
  }

 private:
  LocalIndex n_waves_ = 0;
  std::vector<LocalIndex> plane_, cell_, node_, end_;
};

/// Things sorted by wave: those of wave w are the elements first[w] to first[w + 1].
class WaveRanges {
 public:
  /// `wave(k)`, ascending, of `n` things. Not collective.
  template <class Wave>
  void assign(LocalIndex n_waves, std::size_t n, Wave wave) {
    first_.assign(static_cast<std::size_t>(n_waves) + 1, 0);
    for (std::size_t k = 0; k < n; ++k) ++first_[static_cast<std::size_t>(wave(k)) + 1];
    for (std::size_t w = 0; w + 1 < first_.size(); ++w) first_[w + 1] += first_[w];
  }
  std::size_t begin(LocalIndex wave) const { return first_[static_cast<std::size_t>(wave)]; }
  std::size_t end(LocalIndex wave) const { return first_[static_cast<std::size_t>(wave) + 1]; }
  template <class Thing>
  std::span<const Thing> of(const std::vector<Thing>& things, LocalIndex wave) const {
    return {things.data() + begin(wave), end(wave) - begin(wave)};
  }

 private:
  std::vector<std::size_t> first_;
};

}  // namespace bulkley
