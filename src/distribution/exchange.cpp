#include "distribution/exchange.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <tuple>

#include "distribution/message_tags.hpp"

namespace bulkley {

namespace {

LocalIndex index_in(const PoolLayout& layout, LocalIndex slot, int column, int z) {
  return layout.row_offsets()[static_cast<std::size_t>(slot) * tile_width * tile_width + static_cast<std::size_t>(column)] +
         z;
}

// The numbers of nodes as one array, and those of node n.
const double* numbers(const Node* nodes) { return reinterpret_cast<const double*>(nodes); }
double* numbers(Node* nodes) { return reinterpret_cast<double*>(nodes); }
const double* numbers(const NodePair* nodes) { return reinterpret_cast<const double*>(nodes); }
double* numbers(NodePair* nodes) { return reinterpret_cast<double*>(nodes); }
template <int width, class Number>
Number* numbers_of(Number* nodes, LocalIndex n) {
  return nodes + std::ptrdiff_t{n} * width;
}

// Stretches of numbers that follow each other.
template <class Stretch>
void append(std::vector<Stretch>& stretches, LocalIndex n, LocalIndex count) {
  if (!stretches.empty() && stretches.back().first + stretches.back().count == n)
    stretches.back().count += count;
  else
    stretches.push_back({n, count});
}

}  // namespace

Exchange::Exchange(const Comm& comm, const GridGeometry& grid) : comm_(comm), grid_(grid) {
  static_assert(sizeof(Node) == 4 * sizeof(double));
}

Exchange::Exchange(const Comm& comm, const GridGeometry& grid, const TileMap& map, const PoolLayout& pool)
    : Exchange(comm, grid) {
  set_pool(map, pool);
  Neighbours neighbours(comm);
  neighbours.introduce(owners());
  connect(neighbours);
}

Exchange::Link& Exchange::link_to(int rank) {
  const auto at =
      std::lower_bound(links_.begin(), links_.end(), rank, [](const Link& link, int other) { return link.rank < other; });
  return at != links_.end() && at->rank == rank ? *at : *links_.insert(at, Link(rank));
}

// The nodes of a pool by who owns them and by the tile that they lie in.
void Exchange::set_pool(const TileMap& map, const PoolLayout& pool) {
  struct Owned {
    int rank;
    TilePiece piece;
  };
  const NodeOwner owner(grid_, map);
  mine_.clear();
  beyond_.clear();
  std::vector<Owned> others;
  for (const NodeRow& row : pool.rows()) {
    const int i = grid_.wrapped(0, row.i), j = grid_.wrapped(1, row.j);
    const bool exists = i < grid_.n_nodes(0) && j < grid_.n_nodes(1);
    for (LocalIndex n = 0, count; n < row.count; n += count) {
      const int k = grid_.wrapped(2, row.k + n);
      count = row.count - n;
      if (!exists || k >= grid_.n_nodes(2)) {  // nor do the nodes above it exist
        append(beyond_, row.offset + n, count);
        continue;
      }
      count = std::min({count, tile_width - k % tile_width, grid_.n_nodes(2) - k});
      const Int3 tile{i / tile_width, j / tile_width, k / tile_width};
      const TilePiece piece{grid_.tile_index(tile), i % tile_width * tile_width + j % tile_width, k % tile_width,
                            row.offset + n, count};
      const int rank = owner(tile);
      if (rank == comm_.rank())
        mine_.push_back(piece);
      else
        others.push_back({rank, piece});
    }
  }
  std::sort(others.begin(), others.end(), [](const Owned& a, const Owned& b) {
    return std::tie(a.rank, a.piece.tile, a.piece.pool) < std::tie(b.rank, b.piece.tile, b.piece.pool);
  });
  moved_ = true;
  for (Link& link : links_) {
    link.out.clear();
    link.out_pool.clear();
    link.n_out = 0;
  }
  std::vector<TilePiece> pieces;
  for (auto at = others.begin(); at != others.end();) {
    const int rank = at->rank;
    pieces.clear();
    for (; at != others.end() && at->rank == rank; ++at) pieces.push_back(at->piece);
    plan_link(pieces, link_to(rank));
  }
}

// From pieces by tile: the tiles with their nodes, and where those are in the pool.
void Exchange::plan_link(const std::vector<TilePiece>& pieces, Link& link) {
  struct Places {
    std::uint64_t nodes = 0;
    std::array<LocalIndex, tile_nodes> pool;
  };
  std::vector<Places> places;  // of one tile; more than one where nodes are in the pool more than once
  for (auto at = pieces.begin(); at != pieces.end();) {
    const TileIndex tile = at->tile;
    places.clear();
    for (; at != pieces.end() && at->tile == tile; ++at)
      for (LocalIndex n = 0; n < at->count; ++n) {
        const int place = at->column * tile_width + at->z + n;
        auto free = std::find_if(places.begin(), places.end(), [&](const Places& p) { return !(p.nodes >> place & 1); });
        if (free == places.end()) free = places.emplace(places.end());
        free->nodes |= std::uint64_t{1} << place;
        free->pool[static_cast<std::size_t>(place)] = at->pool + n;
      }
    for (const Places& p : places) {
      link.out.push_back({tile, p.nodes});
      for (std::uint64_t left = p.nodes; left; left &= left - 1)
        append(link.out_pool, p.pool[static_cast<std::size_t>(std::countr_zero(left))], 1);
      link.n_out += std::popcount(p.nodes);
    }
  }
}

std::vector<int> Exchange::owners() const {
  std::vector<int> ranks;
  for (const Link& link : links_)
    if (!link.out.empty()) ranks.push_back(link.rank);
  return ranks;
}

bool Exchange::connect(const Neighbours& neighbours) {
  const bool others_moved = trade_plans(neighbours);
  const bool changed = moved_ || others_moved;
  moved_ = false;
  if (changed) lay_out_owned();
  return changed;
}

// A plan in a message: the generation of the neighbours, the number of the plan, then tiles and nodes; or the first two alone,
// where it is the one that they have. True if any that came is new.
bool Exchange::trade_plans(const Neighbours& neighbours) {
  const auto per_tile = static_cast<std::ptrdiff_t>(sizeof(TileNodes) / sizeof(std::int64_t));
  std::vector<std::vector<std::int64_t>> sent;
  sent.reserve(neighbours.ranks().size());
  requests_.clear();
  for (const int rank : neighbours.ranks()) {
    Link& link = link_to(rank);
    const bool news = link.out != link.told;
    if (news) ++link.out_plan;
    std::vector<std::int64_t>& message = sent.emplace_back();
    message = {neighbours.generation(), link.out_plan};
    if (news)
      for (const TileNodes& tile : link.out)
        message.insert(message.end(), {tile.tile, std::bit_cast<std::int64_t>(tile.nodes)});
    if (news) link.told = link.out;
    BULKLEY_MPI(MPI_Isend(message.data(), static_cast<int>(message.size()), MPI_INT64_T, rank, message_tag::plans,
                          comm_.get(), &requests_.emplace_back()));
  }
  bool any_new = false;
  std::vector<std::int64_t> message;
  for (const int rank : neighbours.ranks()) {
    MPI_Message handle;
    MPI_Status status;
    BULKLEY_MPI(MPI_Mprobe(rank, message_tag::plans, comm_.get(), &handle, &status));
    int size = 0;
    BULKLEY_MPI(MPI_Get_count(&status, MPI_INT64_T, &size));
    message.resize(static_cast<std::size_t>(size));
    BULKLEY_MPI(MPI_Mrecv(message.data(), size, MPI_INT64_T, &handle, MPI_STATUS_IGNORE));
    expect_number(comm_, "map", rank, message[0], neighbours.generation());
    Link& link = link_to(rank);
    if (message[1] == link.in_plan) continue;
    any_new = true;
    link.in_plan = message[1];
    link.in.clear();
    link.n_in = 0;
    for (auto at = message.begin() + 2; at != message.end(); at += per_tile) {
      link.in.push_back({at[0], std::bit_cast<std::uint64_t>(at[1])});
      link.n_in += std::popcount(link.in.back().nodes);
    }
  }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
  return any_new;
}

// The nodes that this rank owns and some pool reaches, and where in them all that is exchanged lies.
void Exchange::lay_out_owned() {
  std::vector<TileIndex> tiles;
  for (const Link& link : links_)
    for (const TileNodes& nodes : link.in) tiles.push_back(static_cast<TileIndex>(nodes.tile));
  for (const TilePiece& piece : mine_)
    if (tiles.empty() || tiles.back() != piece.tile) tiles.push_back(piece.tile);
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  owned_ = PoolLayout(grid_, std::move(tiles), tile_width);

  std::vector<LocalIndex> by_others;
  sent_by_add_ = sent_by_get_ = {};
  for (Link& link : links_) {
    link.in_owned.clear();
    for (const TileNodes& nodes : link.in) {
      const LocalIndex slot = owned_.slot(static_cast<TileIndex>(nodes.tile));
      for (std::uint64_t left = nodes.nodes; left; left &= left - 1) {
        const int place = std::countr_zero(left);
        append(link.in_owned, index_in(owned_, slot, place / tile_width, place % tile_width), 1);
      }
    }
    for (const Stretch& stretch : link.in_owned)
      for (LocalIndex n = 0; n < stretch.count; ++n) by_others.push_back(stretch.first + n);
    sent_by_add_.bytes += static_cast<std::size_t>(link.n_out) * sizeof(Node);
    sent_by_get_.bytes += static_cast<std::size_t>(link.n_in) * sizeof(Node);
    sent_by_add_.n_messages += link.n_out > 0;
    sent_by_get_.n_messages += link.n_in > 0;
  }

  std::vector<Piece> local;
  for (const TilePiece& piece : mine_) {
    const LocalIndex at = index_in(owned_, owned_.slot(piece.tile), piece.column, piece.z);
    if (!local.empty() && local.back().pool + local.back().count == piece.pool &&
        local.back().owned + local.back().count == at)
      local.back().count += piece.count;
    else
      local.push_back({piece.pool, at, piece.count});
  }
  const std::vector<LocalIndex> here = reach_locally(std::move(local));
  std::sort(by_others.begin(), by_others.end());
  by_others.erase(std::unique(by_others.begin(), by_others.end()), by_others.end());
  std::vector<LocalIndex> only_others;
  std::set_difference(by_others.begin(), by_others.end(), here.begin(), here.end(), std::back_inserter(only_others));
  only_others_.clear();
  for (const LocalIndex n : only_others) append(only_others_, n, 1);
  active_.resize(here.size() + only_others.size());
  std::merge(here.begin(), here.end(), only_others.begin(), only_others.end(), active_.begin());
}

std::vector<Int3> Exchange::active_positions() const {
  std::vector<Int3> positions;
  positions.reserve(active_.size());
  auto row = owned_.rows().begin();
  for (const LocalIndex n : active_) {
    while (n >= row->offset + row->count) ++row;
    positions.push_back({row->i, row->j, row->k + (n - row->offset)});
  }
  return positions;
}

// Divides the pieces that this rank owns into first_ and again_. Returns the owned nodes that they reach, ascending.
std::vector<LocalIndex> Exchange::reach_locally(std::vector<Piece> pieces) {
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.owned < b.owned; });
  first_.clear();
  again_.clear();
  std::vector<LocalIndex> reached;
  for (const Piece& piece : pieces) {
    const LocalIndex end = reached.empty() ? 0 : reached.back() + 1;
    const LocalIndex n_again = std::clamp(end - piece.owned, 0, piece.count);
    if (n_again > 0) again_.push_back({piece.pool, piece.owned, n_again});
    if (n_again == piece.count) continue;
    first_.push_back({piece.pool + n_again, piece.owned + n_again, piece.count - n_again});
    for (LocalIndex n = n_again; n < piece.count; ++n) reached.push_back(piece.owned + n);
  }
  return reached;
}

// One message along each link that carries nodes of `width` numbers: `fill(link, to)` writes what is sent, `local()` is done
// while it travels, `take(link, from)` reads what has come.
template <int width, class Fill, class Local, class Take>
void Exchange::exchange_along(const Direction& direction, Fill fill, Local local, Take take) {
  const auto size_of = [](LocalIndex n) { return n > 0 ? 1 + static_cast<std::size_t>(n) * width : 0; };
  std::size_t n_sent = 0, n_received = 0;
  for (const Link& link : links_) {
    n_sent += size_of(link.*direction.n_sent);
    n_received += size_of(link.*direction.n_received);
  }
  if (sent_.size() < n_sent) sent_.resize(n_sent);
  if (received_.size() < n_received) received_.resize(n_received);
  requests_.clear();
  double* into = received_.data();
  for (const Link& link : links_) {
    const std::size_t size = size_of(link.*direction.n_received);
    if (size == 0) continue;
    BULKLEY_MPI(MPI_Irecv(into, static_cast<int>(size), MPI_DOUBLE, link.rank, direction.tag, comm_.get(),
                          &requests_.emplace_back()));
    into += size;
  }
  double* from = sent_.data();
  for (const Link& link : links_) {
    const std::size_t size = size_of(link.*direction.n_sent);
    if (size == 0) continue;
    from[0] = static_cast<double>(link.*direction.sent_plan);
    fill(link, from + 1);
    BULKLEY_MPI(MPI_Isend(from, static_cast<int>(size), MPI_DOUBLE, link.rank, direction.tag, comm_.get(),
                          &requests_.emplace_back()));
    from += size;
  }
  local();
  const double begin = MPI_Wtime();
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE));
  seconds_waiting_ += MPI_Wtime() - begin;
  const double* arrived = received_.data();
  for (const Link& link : links_) {
    const std::size_t size = size_of(link.*direction.n_received);
    if (size == 0) continue;
    expect_number(comm_, "plan", link.rank, static_cast<GlobalIndex>(arrived[0]), link.*direction.received_plan);
    take(link, arrived + 1);
    arrived += size;
  }
}

// Pools into owners: `local()` for the nodes of this rank's pool, `take(stretch, from)` for those of the others.
template <int width, class Local, class Take>
void Exchange::add_between(const double* pool, Local local, Take take) {
  const Direction to_owners{message_tag::node_sums, &Link::n_out, &Link::n_in, &Link::out_plan, &Link::in_plan};
  exchange_along<width>(
      to_owners,
      [&](const Link& link, double* to) {
        for (const Stretch& stretch : link.out_pool)
          to = std::copy_n(numbers_of<width>(pool, stretch.first), std::ptrdiff_t{stretch.count} * width, to);
      },
      local,
      [&](const Link& link, const double* from) {
        for (const Stretch& stretch : link.in_owned) {
          take(stretch, from);
          from += std::ptrdiff_t{stretch.count} * width;
        }
      });
}

// Owners into pools: `give(stretch, to)` for nodes that others reach, `local()` for those of this rank.
template <int width, class Give, class Local>
void Exchange::get_between(double* pool, Give give, Local local) {
  const Direction to_pools{message_tag::node_values, &Link::n_in, &Link::n_out, &Link::in_plan, &Link::out_plan};
  exchange_along<width>(
      to_pools,
      [&](const Link& link, double* to) {
        for (const Stretch& stretch : link.in_owned) {
          give(stretch, to);
          to += std::ptrdiff_t{stretch.count} * width;
        }
      },
      [&] {
        local();
        for (const Stretch& stretch : beyond_)
          std::fill_n(numbers_of<width>(pool, stretch.first), std::ptrdiff_t{stretch.count} * width, 0.0);
      },
      [&](const Link& link, const double* from) {
        for (const Stretch& stretch : link.out_pool) {
          std::copy_n(from, std::ptrdiff_t{stretch.count} * width, numbers_of<width>(pool, stretch.first));
          from += std::ptrdiff_t{stretch.count} * width;
        }
      });
}

// Sums begin at +0 and thus never become -0: 0 + -0 is 0.
template <int width>
void Exchange::add_numbers(const double* pool, double* owned) {
  const auto add_stretch = [&](LocalIndex first, LocalIndex count, const double* from) {
    double* const to = numbers_of<width>(owned, first);
    for (std::ptrdiff_t n = 0, end = std::ptrdiff_t{count} * width; n < end; ++n) to[n] += from[n];
  };
  add_between<width>(
      pool,
      [&] {
        for (const Piece& piece : first_) {
          const double* const from = numbers_of<width>(pool, piece.pool);
          double* const to = numbers_of<width>(owned, piece.owned);
          for (std::ptrdiff_t n = 0, end = std::ptrdiff_t{piece.count} * width; n < end; ++n) to[n] = 0.0 + from[n];
        }
        for (const Stretch& stretch : only_others_)
          std::fill_n(numbers_of<width>(owned, stretch.first), std::ptrdiff_t{stretch.count} * width, 0.0);
        for (const Piece& piece : again_) add_stretch(piece.owned, piece.count, numbers_of<width>(pool, piece.pool));
      },
      [&](const Stretch& stretch, const double* from) { add_stretch(stretch.first, stretch.count, from); });
}

template <int width>
void Exchange::get_numbers(const double* owned, double* pool) {
  get_between<width>(
      pool,
      [&](const Stretch& stretch, double* to) {
        std::copy_n(numbers_of<width>(owned, stretch.first), std::ptrdiff_t{stretch.count} * width, to);
      },
      [&] {
        for (const std::vector<Piece>* pieces : {&first_, &again_})
          for (const Piece& piece : *pieces)
            std::copy_n(numbers_of<width>(owned, piece.owned), std::ptrdiff_t{piece.count} * width,
                        numbers_of<width>(pool, piece.pool));
      });
}

void Exchange::add(const NodePair* pool, Node* motion, Node* change) {
  const auto add_to = [](Node& node, const Node& other) {
    for (int c = 0; c < 4; ++c) node.c[c] += other.c[c];
  };
  const auto add_stretch = [&](LocalIndex first, LocalIndex count, const NodePair* from) {
    for (LocalIndex n = 0; n < count; ++n) {
      add_to(motion[first + n], from[n].motion);
      add_to(change[first + n], from[n].change);
    }
  };
  add_between<8>(
      numbers(pool),
      [&] {
        for (const Piece& piece : first_) {
          std::fill_n(motion + piece.owned, piece.count, Node{});
          std::fill_n(change + piece.owned, piece.count, Node{});
          add_stretch(piece.owned, piece.count, pool + piece.pool);
        }
        for (const Stretch& stretch : only_others_) {
          std::fill_n(motion + stretch.first, stretch.count, Node{});
          std::fill_n(change + stretch.first, stretch.count, Node{});
        }
        for (const Piece& piece : again_) add_stretch(piece.owned, piece.count, pool + piece.pool);
      },
      [&](const Stretch& stretch, const double* from) {
        for (LocalIndex n = 0; n < stretch.count; ++n, from += 8)
          for (int c = 0; c < 4; ++c) {
            motion[stretch.first + n].c[c] += from[c];
            change[stretch.first + n].c[c] += from[4 + c];
          }
      });
}

void Exchange::get(const Node* motion, const Node* change, NodePair* pool) {
  get_between<8>(
      numbers(pool),
      [&](const Stretch& stretch, double* to) {
        for (LocalIndex n = 0; n < stretch.count; ++n) {
          to = std::copy_n(motion[stretch.first + n].c, 4, to);
          to = std::copy_n(change[stretch.first + n].c, 4, to);
        }
      },
      [&] {
        for (const std::vector<Piece>* pieces : {&first_, &again_})
          for (const Piece& piece : *pieces)
            for (LocalIndex n = 0; n < piece.count; ++n)
              pool[piece.pool + n] = {motion[piece.owned + n], change[piece.owned + n]};
      });
}

void Exchange::add(const Node* pool, Node* owned) { add_numbers<4>(numbers(pool), numbers(owned)); }
void Exchange::add(const double* pool, double* owned) { add_numbers<1>(pool, owned); }
void Exchange::get(const Node* owned, Node* pool) { get_numbers<4>(numbers(owned), numbers(pool)); }
void Exchange::get(const double* owned, double* pool) { get_numbers<1>(owned, pool); }

}  // namespace bulkley
