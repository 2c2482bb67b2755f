#pragma once
// Between a rank's pool of nodes and the owners of the nodes: a PetscSF to other ranks, a plain loop within the rank.

#include <petscsf.h>

#include <span>
#include <vector>

#include "bulkley/domain/grid.hpp"

namespace bulkley {

using SfHandle = PetscHandle<PetscSF, PetscSFDestroy>;

/// Adds pools into owners and brings owners' values back to the pools, for one PoolLayout per rank. Pool nodes beyond the
/// grid's last node take no part; along periodic axes there are none, footprints wrap to the first nodes. The order of the
/// additions is not defined: kernels round their contributions so that it does not matter (docs/theory.md, "Order-free
/// sums").
class Exchange {
 public:
  Exchange(const Comm& comm, const Grid& grid, const PoolLayout& layout);  ///< Collective.
  ~Exchange();
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  /// Owned nodes that some rank's pool reaches, ascending; the only ones a step needs to touch.
  std::span<const LocalIndex> active_nodes() const { return active_; }

  /// owned[n] += sum over ranks of their pool copies of node n. The caller zeroes `owned` (active nodes) before. Collective.
  void add(const Node* pool, Node* owned);
  /// pool = owned, for every pool node of the grid; pool nodes beyond it become zero. Collective.
  void get(const Node* owned, Node* pool);

  /// Bytes that this rank sends to others in one add (and receives in one get), and to how many ranks.
  std::size_t bytes_remote() const { return bytes_remote_; }
  int n_neighbours() const { return n_neighbours_; }

 private:
  /// Pool nodes pool .. pool + count - 1 are the owned nodes `owned`, owned + owned_plane_, …: a run in z.
  struct LocalPiece {
    LocalIndex pool, owned, count;
  };

  MPI_Datatype node_type_ = MPI_DATATYPE_NULL;
  SfHandle sf_;                    ///< leaves: pool nodes that other ranks own; roots: the nodes of their owners
  std::vector<LocalPiece> local_;  ///< pool nodes that this rank owns
  LocalIndex owned_plane_ = 0;     ///< owned nodes per z
  std::vector<LocalIndex> active_;
  std::vector<LocalIndex> beyond_;  ///< pool nodes that are not nodes of the grid
  std::size_t bytes_remote_ = 0;
  int n_neighbours_ = 0;
};

}  // namespace bulkley
