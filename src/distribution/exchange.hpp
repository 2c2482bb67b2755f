#pragma once
// Between a rank's pool of nodes and the owners of the nodes: a PetscSF to other ranks, copies of rows within the rank.

#include <petscsf.h>

#include <span>
#include <vector>

#include "bulkley/parallel/petsc.hpp"
#include "grid/node_pool.hpp"
#include "grid/tile_map.hpp"

namespace bulkley {

using SfHandle = PetscHandle<PetscSF, PetscSFDestroy>;

/// Adds pools into owners and brings owners' values back to the pools, for one PoolLayout per rank. The owner of a tile owns
/// its nodes too (NodeOwner), so that only the halos of pools are exchanged; a rank keeps the nodes of those of its tiles
/// that some pool reaches, and empty space costs nothing. Pool nodes beyond the grid's last node take no part; along
/// periodic axes there are none, footprints wrap to the first nodes. The order of the additions is not defined: kernels
/// round their contributions so that it does not matter (docs/theory.md, "Order-free sums").
class Exchange {
 public:
  /// `map`: the same on every rank. Collective.
  Exchange(const Comm& comm, const GridGeometry& grid, const TileMap& map, const PoolLayout& pool);
  ~Exchange();
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  /// Size of the arrays of owned nodes below.
  LocalIndex n_owned() const { return owned_.n_nodes(); }
  /// Owned nodes that some rank's pool reaches, ascending; the only ones a step needs to touch.
  std::span<const LocalIndex> active_nodes() const { return active_; }
  /// Their grid indices. Not collective.
  std::vector<Int3> active_positions() const;

  /// owned[n] = sum over ranks of their pool copies of node n, for every active node n; never -0. Collective.
  void add(const Node* pool, Node* owned);
  /// The same for pools of one number a node.
  void add(const double* pool, double* owned);
  /// The same for pools of pairs, whose halves go to arrays of their own, in one message to each rank.
  void add(const NodePair* pool, Node* motion, Node* change);
  /// pool = owned, for every pool node of the grid; pool nodes beyond it become zero. Collective.
  void get(const Node* owned, Node* pool);
  void get(const double* owned, double* pool);
  void get(const Node* motion, const Node* change, NodePair* pool);

  /// What one rank sends to others in one call, for pools of Nodes; NodePairs take twice the bytes.
  struct Traffic {
    std::size_t bytes = 0;
    int n_messages = 0;
  };
  Traffic sent_by_add() const { return sent_by_add_; }
  Traffic sent_by_get() const { return sent_by_get_; }
  /// Wall time so far between having nothing left to do and having what the others send, s.
  double seconds_waiting() const { return seconds_waiting_; }

 private:
  /// Pool nodes pool .. pool + count - 1 are the owned nodes owned .. owned + count - 1.
  struct Piece {
    LocalIndex pool, owned, count;
  };
  /// Pool nodes pool .. pool + count - 1.
  struct PoolPiece {
    LocalIndex pool, count;
  };
  struct Reach;
  Reach divide(const GridGeometry& grid, const TileMap& map, const PoolLayout& pool, int rank);
  void connect(const Comm& comm, const GridGeometry& grid, Reach& reach);
  std::vector<LocalIndex> reach_locally(std::vector<Piece> pieces);
  template <int n_numbers>
  void add_numbers(MPI_Datatype type, const double* pool, double* owned);
  template <int n_numbers>
  void get_numbers(MPI_Datatype type, const double* owned, double* pool);

  PoolLayout owned_;  ///< of the tiles of nodes that this rank owns and some pool reaches
  MPI_Datatype node_type_ = MPI_DATATYPE_NULL, pair_type_ = MPI_DATATYPE_NULL;
  SfHandle sf_;                          ///< leaves: pool nodes that other ranks own; roots: the nodes of their owners
  std::vector<Piece> first_;             ///< pool nodes that this rank owns, each owned node once
  std::vector<Piece> again_;             ///< those that reach an owned node once more, across a periodic boundary
  std::vector<LocalIndex> by_others_;    ///< owned nodes that other ranks' pools reach
  NodePairVector pairs_;                 ///< what other ranks add to those nodes, or get of them; by owned node
  std::vector<LocalIndex> only_others_;  ///< owned nodes that only other ranks' pools reach
  std::vector<PoolPiece> beyond_;        ///< pool nodes that are not nodes of the grid
  std::vector<LocalIndex> active_;
  Traffic sent_by_add_, sent_by_get_;
  double seconds_waiting_ = 0.0;
};

}  // namespace bulkley
