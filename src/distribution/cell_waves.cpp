#include "distribution/cell_waves.hpp"

#include <algorithm>

namespace bulkley {

CellWaves::CellWaves(const CellGrid& cells, std::span<const CellGrid::Copy> joined)
    : cell_(static_cast<std::size_t>(cells.n_ids()), 0), node_(static_cast<std::size_t>(cells.n_nodes()), 0) {
  const int width = cells.width();
  int x = -1;
  LocalIndex end = 0;
  for (const LocalIndex id : cells.order()) {
    if (const int here = cells.position(id)[0]; here != x) {
      x = here;
      end_.push_back(end);
      ++n_waves_;
    }
    plane_.push_back(n_waves_ - 1);
    for (const LocalIndex first : cells.rows(id)) {
      for (LocalIndex n = first; n < first + width; ++n) node_[static_cast<std::size_t>(n)] = n_waves_ - 1;
      end = end_.back() = std::max(end, first + width);
    }
  }
  if (!end_.empty()) end_.back() = cells.n_nodes();
  const auto join = [&](std::span<const CellGrid::Copy> pairs) {
    bool changed = false;
    for (const CellGrid::Copy& pair : pairs) {
      LocalIndex &one = node_[static_cast<std::size_t>(pair.node)], &other = node_[static_cast<std::size_t>(pair.other)];
      changed = changed || one != other;
      one = other = std::max(one, other);
    }
    return changed;
  };
  for (bool changed = true; changed;) {
    changed = join(joined);
    changed = join(cells.repeated()) || changed;
  }
  for (const LocalIndex id : cells.order()) {
    LocalIndex& wave = cell_[static_cast<std::size_t>(id)];
    for (const LocalIndex first : cells.rows(id))
      for (LocalIndex n = first; n < first + width; ++n) wave = std::max(wave, node_[static_cast<std::size_t>(n)]);
  }
}

}  // namespace bulkley
