#pragma once
// Between a rank's pool of nodes and the owners of the nodes: messages between neighbours, copies of rows within the rank.

#include <cstdint>
#include <span>
#include <vector>

#include "distribution/neighbours.hpp"
#include "grid/node_pool.hpp"
#include "grid/tile_map.hpp"

namespace bulkley {

/// Adds pools into owners and brings owners' values back to the pools. The owner of a tile owns its nodes too (NodeOwner), so
/// that only the halos of pools are exchanged; a rank keeps the nodes of those of its tiles that some pool reaches, and empty
/// space costs nothing. Pool nodes beyond the grid's last node take no part; along periodic axes there are none, footprints
/// wrap to the first nodes. The order of the additions is not defined: kernels round their contributions so that it does not
/// matter (docs/theory.md, "Order-free sums").
///
/// Two neighbours agree on a plan: the tiles and nodes of the one that the other's pool reaches, in the order in which their
/// values travel. Each translates it to places in its own arrays, which the other does not know; so a rank may change its pool
/// at will, and has to tell only those neighbours whose nodes it reaches otherwise than before.
class Exchange {
 public:
  /// No pool yet. `comm` must outlive this. Not collective.
  Exchange(const Comm& comm, const GridGeometry& grid);
  /// With a pool on every rank, and neighbours of its own. `map`: the same on every rank. Collective.
  Exchange(const Comm& comm, const GridGeometry& grid, const TileMap& map, const PoolLayout& pool);

  /// `pool` is this rank's from now on; `connect` must follow before anything is exchanged. `map`: as at every other call. Not
  /// collective.
  void set_pool(const TileMap& map, const PoolLayout& pool);
  /// The ranks that own nodes of the pool, without this one, ascending.
  std::vector<int> owners() const;
  /// Tells neighbours which of their nodes the pool reaches, where that has changed, and learns the same. Between neighbours:
  /// each of them must call it, and owners() must be among them. True where the pool or the owned nodes have changed since
  /// the last call, and arrays made for them do not fit any more.
  bool connect(const Neighbours& neighbours);

  /// Size of the arrays of owned nodes below.
  LocalIndex n_owned() const { return owned_.n_nodes(); }
  /// Owned nodes that some rank's pool reaches, ascending; the only ones a step needs to touch.
  std::span<const LocalIndex> active_nodes() const { return active_; }
  /// Their grid indices. Not collective.
  std::vector<Int3> active_positions() const;

  /// owned[n] = sum over ranks of their pool copies of node n, for every active node n; never -0. Between neighbours.
  void add(const Node* pool, Node* owned);
  /// The same for pools of one number a node.
  void add(const double* pool, double* owned);
  /// The same for pools of pairs, whose halves go to arrays of their own, in one message to each rank.
  void add(const NodePair* pool, Node* motion, Node* change);
  /// pool = owned, for every pool node of the grid; pool nodes beyond it become zero. Between neighbours.
  void get(const Node* owned, Node* pool);
  void get(const double* owned, double* pool);
  void get(const Node* motion, const Node* change, NodePair* pool);

  /// What one rank sends to others in one call, for pools of Nodes; NodePairs take twice the bytes. The number of the plan that
  /// goes with each message is not counted.
  struct Traffic {
    std::size_t bytes = 0;
    int n_messages = 0;
  };
  Traffic sent_by_add() const { return sent_by_add_; }
  Traffic sent_by_get() const { return sent_by_get_; }
  /// Wall time so far between having nothing left to do and having what the others send, s.
  double seconds_waiting() const { return seconds_waiting_; }

 private:
  /// Nodes of a tile: bit 16 x + 4 y + z of `nodes`.
  struct TileNodes {
    std::int64_t tile;
    std::uint64_t nodes;
    bool operator==(const TileNodes&) const = default;
  };
  /// Nodes first .. first + count - 1 of the pool, or of the owned ones.
  struct Stretch {
    LocalIndex first, count;
  };
  /// Pool nodes pool .. pool + count - 1 are the owned nodes owned .. owned + count - 1.
  struct Piece {
    LocalIndex pool, owned, count;
  };
  /// Pool nodes that are nodes of one tile of this rank, one after the other along z.
  struct TilePiece {
    TileIndex tile;
    int column, z;  ///< of the first node within the tile: 4 x + y, z
    LocalIndex pool, count;
  };
  /// What is exchanged with one other rank. Where a node is twice in the pool, across a periodic boundary, its tile is twice
  /// in the plan.
  struct Link {
    explicit Link(int other) : rank(other) {}
    int rank;
    std::vector<TileNodes> out;     ///< nodes of theirs that this rank's pool reaches
    std::vector<TileNodes> told;    ///< `out` as they know it
    std::vector<TileNodes> in;      ///< nodes of this rank that their pool reaches
    std::vector<Stretch> out_pool;  ///< where those of `out` are in the pool
    std::vector<Stretch> in_owned;  ///< and those of `in` among the owned ones
    LocalIndex n_out = 0, n_in = 0;
    std::int64_t out_plan = 0, in_plan = 0;  ///< numbers of the plans: how often they have changed
  };
  /// Which way nodes travel along links.
  struct Direction {
    int tag;
    LocalIndex Link::*n_sent;
    LocalIndex Link::*n_received;
    std::int64_t Link::*sent_plan;
    std::int64_t Link::*received_plan;
  };

  Link& link_to(int rank);
  static void plan_link(const std::vector<TilePiece>& pieces, Link& link);
  bool trade_plans(const Neighbours& neighbours);
  void lay_out_owned();
  std::vector<LocalIndex> reach_locally(std::vector<Piece> pieces);
  template <int width, class Fill, class Local, class Take>
  void exchange_along(const Direction& direction, Fill fill, Local local, Take take);
  template <int width, class Local, class Take>
  void add_between(const double* pool, Local local, Take take);
  template <int width, class Give, class Local>
  void get_between(double* pool, Give give, Local local);
  template <int width>
  void add_numbers(const double* pool, double* owned);
  template <int width>
  void get_numbers(const double* owned, double* pool);

  const Comm& comm_;
  GridGeometry grid_;
  std::vector<Link> links_;           ///< by rank; to those with which nodes have been exchanged
  std::vector<TilePiece> mine_;       ///< of the pool, what this rank owns
  bool moved_ = false;                ///< the pool has changed since the last `connect`
  PoolLayout owned_;                  ///< of the tiles of nodes that this rank owns and some pool reaches
  std::vector<Piece> first_;          ///< pool nodes that this rank owns, each owned node once
  std::vector<Piece> again_;          ///< those that reach an owned node once more, across a periodic boundary
  std::vector<Stretch> only_others_;  ///< owned nodes that only other ranks' pools reach
  std::vector<Stretch> beyond_;       ///< pool nodes that are not nodes of the grid
  std::vector<LocalIndex> active_;
  std::vector<double> sent_, received_;  ///< messages: the number of the plan, then the nodes' numbers
  std::vector<MPI_Request> requests_;    ///< of the messages under way
  Traffic sent_by_add_, sent_by_get_;
  double seconds_waiting_ = 0.0;
};

}  // namespace bulkley
