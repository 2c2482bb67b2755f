#pragma once
// Fields on a whole grid of nodes, empty space included: a PETSc DMDA that knows nothing of tiles and particles.

#include <petscdmda.h>

#include <optional>
#include <string>
#include <vector>

#include "bulkley/parallel/petsc.hpp"
#include "grid/grid_geometry.hpp"

namespace bulkley {

using DmHandle = PetscHandle<DM, DMDestroy>;
using VecHandle = PetscHandle<Vec, VecDestroy>;

/// What lives on a grid of nodes. All the same on every rank.
struct FieldLayout {
  enum class Stencil { star, box };  ///< ghosts along the axes only, or at edges and corners too

  GridGeometry geometry;
  int n_components = 1;   ///< unknowns per node, doubles
  int stencil_width = 0;  ///< layers of ghost nodes
  Stencil stencil = Stencil::star;
  bool wraps = true;  ///< ghosts wrap around the geometry's periodic axes; else those axes end like the others
  Int3 below{0, 0, 0}, above{0, 0, 0};  ///< layers of nodes outside the geometry's, none along axes that wrap
  bool margins = false;  ///< local arrays have ghosts beyond the ends of axes that do not wrap, which nothing fills

  bool wraps_along(int axis) const { return wraps && geometry.periodic[static_cast<std::size_t>(axis)]; }
  int n_nodes(int axis) const {
    const auto a = static_cast<std::size_t>(axis);
    return below[a] + geometry.n_nodes(axis) + above[a];
  }
};

/// Of fields of Nodes: {x, y, z, mass}, no ghosts.
inline FieldLayout node_fields(const GridGeometry& geometry) { return {.geometry = geometry, .n_components = 4}; }

/// How a field's nodes are divided among ranks: a box each, as even as whole nodes allow and as near to cubes. No box is
/// thinner than the stencil is wide. Where so many boxes cannot be cut, as for 67 ranks and 40 x 40 x 40 nodes, the last
/// ranks have none.
struct FieldBoxes {
  Int3 n_boxes{1, 1, 1};                   ///< along each axis; rank (a n_boxes[1] + b) n_boxes[2] + c has box (a, b, c)
  std::array<std::vector<int>, 3> starts;  ///< along each axis: the first node of each box, from 0, and one past the last

  int n_ranks() const { return n_boxes[0] * n_boxes[1] * n_boxes[2]; }
  /// Nodes of a rank; 0 for those without a box.
  GlobalIndex n_nodes(int rank) const;
};

/// Precondition: field_fault is empty. Not collective.
FieldBoxes field_boxes(const FieldLayout& layout, int n_ranks);

/// Why PETSc cannot hold such a field, as a clause; empty where it can: its indices do not number the unknowns, or an axis
/// has fewer nodes than the stencil reaches. Not collective.
std::string field_fault(const FieldLayout& layout);

/// A DMDA of these nodes, divided by field_boxes. Nodes have the indices of the geometry: those below its first are
/// negative. Arrays of a field hold n_components numbers a node, nodes z fastest, as the rows of a pool run. A DMDA numbers
/// its first axis fastest, so inside this class its axes are the grid's reversed, (z, y, x): DMDAVecGetArrayDOF gives an
/// array indexed [i - first index][j][k][component], where the indices are counted from 0 (`below` added).
class FieldGrid {
 public:
  /// Throws UsageError with field_fault. Collective.
  FieldGrid(const Comm& comm, const FieldLayout& layout);
  /// Divided by `boxes`, for at most as many ranks as there are, each box as thick as the stencil is wide. Throws likewise.
  /// Collective.
  FieldGrid(const Comm& comm, const FieldLayout& layout, FieldBoxes boxes);

  const FieldLayout& layout() const { return layout_; }
  int n_components() const { return layout_.n_components; }
  /// Whether this rank has nodes. Only such ranks may call what follows up to create_local, and all of them must where it is
  /// collective.
  bool has_nodes() const { return count_[0] > 0; }
  DM dm() const { return dm_.get(); }
  /// The ranks that have nodes, in the order of all ranks.
  const Comm& comm() const { return part_ ? *part_ : all_; }
  /// Zero Vecs: of the owned nodes; of these and their ghosts. The first is collective over comm().
  VecHandle create_global() const;
  VecHandle create_local() const;

  /// Owned nodes: the first and their number along each axis, 0 where this rank has none.
  const Int3& first() const { return first_; }
  const Int3& count() const { return count_; }
  LocalIndex n_owned() const { return count_[0] * count_[1] * count_[2]; }
  /// Numbers in an array of this rank's nodes.
  std::size_t size() const { return static_cast<std::size_t>(n_owned()) * static_cast<std::size_t>(n_components()); }
  /// Grid indices of the n-th owned node.
  Int3 node(LocalIndex n) const {
    return {first_[0] + n / (count_[1] * count_[2]), first_[1] + n / count_[2] % count_[1], first_[2] + n % count_[2]};
  }
  struct Location {
    int rank;          ///< of all
    LocalIndex index;  ///< into the owner's nodes
  };
  /// Whether (i, j, k) is a node, wrapped along axes that wrap.
  bool contains(const Int3& node) const;
  /// Owner of a node, wrapped likewise. Precondition: contains(node). Not collective.
  Location locate(const Int3& node) const;

 private:
  const Comm& all_;
  FieldLayout layout_;
  FieldBoxes boxes_;
  std::optional<Comm> part_;  ///< where some ranks have no nodes
  DmHandle dm_;
  std::array<std::vector<int>, 3> box_;  ///< along the axis, by node counted from 0
  Int3 first_{0, 0, 0}, count_{0, 0, 0};
};

}  // namespace bulkley
