#pragma once
// The background grid as fields for all to read: a PETSc DMDA of the nodes and its Vecs.

#include <petscdmda.h>

#include "balance/partition.hpp"
#include "bulkley/parallel/petsc.hpp"
#include "grid/node_pool.hpp"

namespace bulkley {

using DmHandle = PetscHandle<DM, DMDestroy>;
using VecHandle = PetscHandle<Vec, VecDestroy>;

/// A DMDA with four unknowns per node ({momentum or velocity, mass}) divided into boxes. Its boundaries
/// are open and its stencil has no width: Exchange, not the DMDA, brings nodes to where a step needs them, and wraps them.
/// Nodes are numbered z fastest, as the rows of a pool run. A DMDA numbers its first axis fastest, so inside this class its
/// axes are the grid's reversed, (z, y, x); DMDAVecGetArrayDOF thus gives an array indexed [i][j][k][component].
class Grid {
 public:
  /// Whether PETSc's indices are wide enough to number the unknowns.
  static bool fits(const GridGeometry& geometry);
  static void check_fits(const GridGeometry& geometry);  ///< Throws UsageError.

  /// Preconditions: the same arguments on every rank; `boxes` are of this grid for comm.size() ranks.
  /// Throws UsageError when it does not fit. Collective.
  Grid(const Comm& comm, const GridGeometry& geometry, const Boxes& boxes);

  const GridGeometry& geometry() const { return geometry_; }
  DM dm() const { return dm_.get(); }
  /// A zero global Vec of this grid; one Node per owned node, z fastest. Collective.
  VecHandle create_vector() const;
  /// Owned index range: first node and number of nodes along each axis.
  const Int3& first() const { return first_; }
  const Int3& count() const { return count_; }
  LocalIndex n_owned() const { return count_[0] * count_[1] * count_[2]; }
  /// Grid indices of the n-th owned node.
  Int3 node(LocalIndex n) const {
    return {first_[0] + n / (count_[1] * count_[2]), first_[1] + n / count_[2] % count_[1], first_[2] + n % count_[2]};
  }
  struct Location {
    int rank;
    LocalIndex index;  ///< into the owner's nodes
  };
  /// Whether (i, j, k) is a node: wrapped along periodic axes, within n_nodes along the others.
  bool contains(const Int3& node) const;
  /// Owner of node (i, j, k), wrapped along periodic axes. Precondition: contains(node). Not collective.
  Location locate(const Int3& node) const;

 private:
  GridGeometry geometry_;
  DmHandle dm_;
  Int3 n_ranks_{1, 1, 1};
  std::array<std::vector<int>, 3> starts_;   ///< first node of each process along the axis, and one past the last
  std::array<std::vector<int>, 3> process_;  ///< process along the axis, by node
  Int3 first_{0, 0, 0}, count_{0, 0, 0};
};

}  // namespace bulkley
