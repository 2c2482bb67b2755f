#pragma once
// One level of a hierarchy of node grids, each twice as coarse as the one before, with the seven-point operator of a diffusion
// problem on it (docs/theory.md, "Magnetic fields").

#include <petscsf.h>

#include <array>
#include <span>
#include <vector>

#include "field/field_grid.hpp"

namespace bulkley {

/// A box of nodes by their grid indices, z fastest.
struct NodeBox {
  Int3 first{0, 0, 0}, count{0, 0, 0};

  std::size_t size() const {
    return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) * static_cast<std::size_t>(count[2]);
  }
  std::ptrdiff_t index(int i, int j, int k) const {
    return (static_cast<std::ptrdiff_t>(i - first[0]) * count[1] + (j - first[1])) * count[2] + (k - first[2]);
  }
  std::ptrdiff_t index(const Int3& n) const { return index(n[0], n[1], n[2]); }
  /// Of a step along `axis`.
  std::ptrdiff_t stride(int axis) const {
    return axis == 2 ? 1 : axis == 1 ? count[2] : static_cast<std::ptrdiff_t>(count[1]) * count[2];
  }
};

/// The nodes that two boxes have in common.
NodeBox common(const NodeBox& a, const NodeBox& b);

/// Numbers of nodes by rows along z: `visit(i, j)` for all rows of a box.
template <class Visit>
void for_rows(const NodeBox& box, Visit visit) {
  for (int i = box.first[0]; i < box.first[0] + box.count[0]; ++i)
    for (int j = box.first[1]; j < box.first[1] + box.count[1]; ++j) visit(i, j);
}

/// Where the nodes of a level are: node (0, 0, 0) is the first of its FieldGrid. The same on every rank.
struct LevelShape {
  Int3 n_nodes{0, 0, 0};  ///< along axes that do not wrap the end nodes are on the faces of the box
  std::array<bool, 3> wraps{false, false, false};
  Vec3 origin = Vec3::Zero();   ///< of node (0, 0, 0), m
  Vec3 spacing = Vec3::Zero();  ///< m

  int n_cells(int axis) const {
    const auto a = static_cast<std::size_t>(axis);
    return wraps[a] ? n_nodes[a] : n_nodes[a] - 1;
  }
  Vec3 position(const Int3& n) const { return origin + Vec3(n[0] * spacing[0], n[1] * spacing[1], n[2] * spacing[2]); }
  /// The share of a cell that a node's own volume has along an axis: half on the faces of the box.
  double share(int axis, int index) const {
    const auto a = static_cast<std::size_t>(axis);
    return !wraps[a] && (index == 0 || index == n_nodes[a] - 1) ? 0.5 : 1.0;
  }
  /// And of a cell's face that its edge along `axis` crosses.
  double share_across(int axis, const Int3& n) const {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    return share(b, n[static_cast<std::size_t>(b)]) * share(c, n[static_cast<std::size_t>(c)]);
  }
};

/// Owned arrays hold the nodes of `owned()`; ghosted ones, of `ghosted()`, have one more layer on all sides, which is zero beyond
/// the box. The operator is (A x)_i = leak_i x_i + sum over the six neighbours j of conductance_ij (x_i - x_j), and with `cross` what couples
/// slopes along two axes at a node: the derivative of sum_i sum_(a<b) cross_i,ab s_a s_b, s_a = (x_(i+a) - x_(i-a))/2.
class FieldLevel {
 public:
  /// `layout`: of so many nodes (coarse_layout, or one whose geometry is the particles' grid). Ranks without a box may only ask
  /// grid(). Collective.
  FieldLevel(const Comm& comm, const LevelShape& shape, const FieldLayout& layout, const FieldBoxes& boxes);

  const LevelShape& shape() const { return shape_; }
  const FieldGrid& grid() const { return grid_; }
  const NodeBox& owned() const { return owned_; }
  const NodeBox& ghosted() const { return ghosted_; }

  /// Fills a ghosted array from an owned one. Collective over grid().comm().
  void spread(std::span<const double> owned, std::span<double> ghosted) const;
  void spread(std::span<const float> owned, std::span<float> ghosted) const;
  /// Fills the ghosts of a ghosted array from its owned part. Collective over grid().comm().
  void refresh(std::span<double> ghosted);

  /// By ghosted node: of the edge to the next node along the axis, zero where there is none.
  std::array<std::vector<double>, 3> conductance;
  /// By ghosted node: of the axes y and z, z and x, x and y; empty where nothing couples.
  std::array<std::vector<double>, 3> cross;
  std::vector<double> leak;  ///< by owned node

  /// The same in single precision, without `cross`, for preconditioners: half the bytes.
  struct Single {
    std::array<std::vector<float>, 3> conductance;  ///< by ghosted node
    std::vector<float> leak, inverse_diagonal;      ///< by owned node
  };
  const Single& single() const { return single_; }
  /// Once conductances and leaks are there; the former have changed on ghosted nodes of `changed` only since the last time. Not
  /// collective.
  void set_single(const NodeBox& changed);
  /// y = A x, in single precision without `cross`, else with it: `x` ghosted, `y` owned. Not collective.
  void multiply(std::span<const float> x, std::span<float> y) const;
  void multiply(std::span<const double> x, std::span<double> y) const;
  /// out_j += sum_a (v_a at j - a less that at j + a)/2 with v_a = sum_b cross_ab slope(b, place), the place being of a ghosted node.
  template <class Slope>
  void add_crossed(Slope slope, std::span<double> out) const;

 private:
  LevelShape shape_;
  FieldGrid grid_;
  NodeBox owned_, ghosted_;
  PetscSF to_ghosted_ = nullptr;  // the DMDA's
  Single single_;
  std::vector<double> scratch_;
};

template <class Slope>
void FieldLevel::add_crossed(Slope slope, std::span<double> out) const {
  for_rows(owned_, [&](int i, int j) {
    for (int k = owned_.first[2]; k < owned_.first[2] + owned_.count[2]; ++k) {
      const std::ptrdiff_t at = ghosted_.index(i, j, k);
      double sum = 0.0;
      for (int a = 0; a < 3; ++a)
        for (const int side : {-1, 1}) {
          const std::ptrdiff_t place = at + side * ghosted_.stride(a);
          for (const int b : {(a + 1) % 3, (a + 2) % 3}) {
            const double coupling = cross[static_cast<std::size_t>(3 - a - b)][static_cast<std::size_t>(place)];
            if (coupling != 0.0) sum -= side * 0.5 * coupling * slope(b, place);
          }
        }
      out[static_cast<std::size_t>(owned_.index(i, j, k))] += sum;
    }
  });
}

/// The nodes of a layout.
LevelShape shape_of(const FieldLayout& layout);
/// A layout of such nodes, on a geometry that means nothing else.
FieldLayout coarse_layout(const LevelShape& shape);

/// Boxes of the nodes of the coarsest of some levels, times 2 for each finer one: a fine node 2 i has the owner of coarse node i. At
/// most one rank a coarsest cell along each axis, so that some ranks may have none. Not collective.
FieldBoxes aligned_boxes(const LevelShape& coarsest, const std::array<int, 3>& factors, const LevelShape& fine, int n_ranks);

}  // namespace bulkley
