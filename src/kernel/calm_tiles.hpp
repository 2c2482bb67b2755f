#pragma once
// Which tiles surely give no particle more motion than some limits, from differences of their nodes.

#include <vector>

#include "kernel/bspline.hpp"
#include "kernel/cells.hpp"
#include "kernel/step_bounds.hpp"

namespace bulkley {

inline const Node& motion_in(const Node& node) { return node; }
inline const Node& motion_in(const NodePair& node) { return node.motion; }

/// Tiles whose nodes bound the speed and the velocity gradient (T26c) of all particles there by `ample`. A tile is looked at when it is
/// first asked for. Refers to what it is given. Not collective.
template <SplineOrder order, class NodeType>
class CalmTiles {
 public:
  /// `cell`: by particle, as in CellMap; `nodes`: velocities, and 0 as the fourth number of a node without mass.
  CalmTiles(const GridGeometry& grid, const PoolLayout& layout, const LocalIndex* cell, const NodeType* nodes,
            LocalIndex n_particles, const MotionLimits& ample)
      : row_offsets_(layout.row_offsets().data()),
        cell_(cell),
        nodes_(nodes),
        speed_squared_(ample.speed * ample.speed),
        difference_squared_(ample.velocity_gradient * ample.velocity_gradient * grid.cell_size * grid.cell_size) {
    // A tile costs as much as a dozen particles.
    const auto n_tiles = layout.tiles().size();
    if (ample.speed > 0.0 && ample.velocity_gradient > 0.0 && n_particles / 32 > static_cast<LocalIndex>(n_tiles))
      answer_.assign(n_tiles, Answer::none);
  }

  /// Whether all of the `size` particles from `first` on are in such tiles. False where there are few particles a tile.
  bool hold(LocalIndex first, int size) {
    if (answer_.empty()) return false;
    for (int n = 0; n < size; ++n) {
      const auto slot = static_cast<std::size_t>(cell_[first + n] / tile_nodes);
      if (answer_[slot] == Answer::none) answer_[slot] = is_calm(slot) ? Answer::calm : Answer::restless;
      if (answer_[slot] == Answer::restless) return false;
    }
    return true;
  }

 private:
  enum class Answer : char { none, calm, restless };

  static double squared(const Node& a, const Node& b) {
    double sum = 0.0;
    for (int r = 0; r < 3; ++r) sum += (a.c[r] - b.c[r]) * (a.c[r] - b.c[r]);
    return sum;
  }

  // Written so that NaN is not calm: it never passes the test of the speed, which every node with mass must.
  bool is_calm(std::size_t slot) const {
    constexpr int w = footprint_width(order);
    const LocalIndex* const offset = row_offsets_ + slot * (w * w);
    double largest[3] = {0.0, 0.0, 0.0};  // squares of differences along each axis
    for (int i = 0; i < w; ++i)
      for (int j = 0; j < w; ++j) {
        const NodeType* const row = nodes_ + offset[i * w + j];
        const NodeType* const along_x = i + 1 < w ? nodes_ + offset[(i + 1) * w + j] : nullptr;
        const NodeType* const along_y = j + 1 < w ? nodes_ + offset[i * w + j + 1] : nullptr;
        for (int k = 0; k < w; ++k) {
          const Node& here = motion_in(row[k]);
          if (here.c[3] == 0.0) continue;
          if (!(squared(here, Node{}) <= speed_squared_)) return false;
          const auto include = [&](int axis, const NodeType& next) {
            if (motion_in(next).c[3] == 0.0) return;
            const double d = squared(here, motion_in(next));
            largest[axis] = d <= largest[axis] ? largest[axis] : d;
          };
          if (along_x) include(0, along_x[k]);
          if (along_y) include(1, along_y[k]);
          if (k + 1 < w) include(2, row[k + 1]);
        }
        if (!(largest[0] + largest[1] + largest[2] <= difference_squared_)) return false;
      }
    return true;
  }

  const LocalIndex* row_offsets_;
  const LocalIndex* cell_;
  const NodeType* nodes_;
  double speed_squared_, difference_squared_;
  std::vector<Answer> answer_;  // by tile; empty: not worth asking
};

}  // namespace bulkley
