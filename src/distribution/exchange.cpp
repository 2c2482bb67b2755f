#include "distribution/exchange.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

#include "distribution/message_sizes.hpp"

namespace bulkley {

namespace {

// Pool nodes pool .. pool + count - 1 are nodes of one tile, one after the other along z.
struct TilePiece {
  int rank;  // that owns the tile
  TileIndex tile;
  int column, z;  // of the first node within the tile: 4 x + y, z
  LocalIndex pool, count;
};

LocalIndex index_in(const PoolLayout& layout, LocalIndex slot, int column, int z) {
  return layout.row_offsets()[static_cast<std::size_t>(slot) * tile_width * tile_width + static_cast<std::size_t>(column)] +
         z;
}

// The numbers of nodes as one array, and those of node n.
const double* numbers(const Node* nodes) { return reinterpret_cast<const double*>(nodes); }
double* numbers(Node* nodes) { return reinterpret_cast<double*>(nodes); }
template <int n_numbers, class Number>
Number* numbers_of(Number* nodes, LocalIndex n) {
  return nodes + std::ptrdiff_t{n} * n_numbers;
}

}  // namespace

// The nodes of a pool by the tile that they lie in.
struct Exchange::Reach {
  std::vector<TilePiece> mine, others;  // others: by rank and tile
};

Exchange::Exchange(const Comm& comm, const GridGeometry& grid, const TileMap& map, const PoolLayout& pool) {
  static_assert(sizeof(Node) == 4 * sizeof(double));
  BULKLEY_MPI(MPI_Type_contiguous(4, MPI_DOUBLE, &node_type_));
  BULKLEY_MPI(MPI_Type_commit(&node_type_));
  BULKLEY_MPI(MPI_Type_contiguous(8, MPI_DOUBLE, &pair_type_));
  BULKLEY_MPI(MPI_Type_commit(&pair_type_));
  Reach reach = divide(grid, map, pool, comm.rank());
  connect(comm, grid, reach);
}

Exchange::Reach Exchange::divide(const GridGeometry& grid, const TileMap& map, const PoolLayout& pool, int rank) {
  const NodeOwner owner(grid, map);
  const auto wrapped = [&](int axis, int index) {
    return grid.periodic[axis] && index >= grid.n_nodes(axis) ? index - grid.n_nodes(axis) : index;
  };
  Reach reach;
  for (const NodeRow& row : pool.rows()) {
    const int i = wrapped(0, row.i), j = wrapped(1, row.j);
    const bool exists = i < grid.n_nodes(0) && j < grid.n_nodes(1);
    for (LocalIndex n = 0, count; n < row.count; n += count) {
      const int k = wrapped(2, row.k + n);
      count = row.count - n;
      if (!exists || k >= grid.n_nodes(2)) {  // nor do the nodes above it exist
        beyond_.push_back({row.offset + n, count});
        continue;
      }
      count = std::min({count, tile_width - k % tile_width, grid.n_nodes(2) - k});
      const Int3 tile{i / tile_width, j / tile_width, k / tile_width};
      const std::int32_t to = owner(tile);
      (to == rank ? reach.mine : reach.others)
          .push_back({to, grid.tile_index(tile), i % tile_width * tile_width + j % tile_width, k % tile_width,
                      row.offset + n, count});
    }
  }
  std::sort(reach.others.begin(), reach.others.end(), [](const TilePiece& a, const TilePiece& b) {
    return std::tie(a.rank, a.tile, a.pool) < std::tie(b.rank, b.tile, b.pool);
  });
  return reach;
}

// Owners learn which of their tiles others reach, and tell them where those nodes are; from that comes the SF.
void Exchange::connect(const Comm& comm, const GridGeometry& grid, Reach& reach) {
  std::vector<MessageSize> requests_out;  // tiles of other ranks
  std::vector<TileIndex> asked_tiles;
  for (std::size_t n = 0; n < reach.others.size(); ++n) {
    const TilePiece& piece = reach.others[n];
    const bool new_rank = n == 0 || piece.rank != reach.others[n - 1].rank;
    if (!new_rank && piece.tile == asked_tiles.back()) continue;
    if (new_rank) requests_out.push_back({piece.rank, 0});
    ++requests_out.back().count;
    asked_tiles.push_back(piece.tile);
  }
  const std::vector<MessageSize> requests_in = exchange_counts(comm, requests_out);
  const std::vector<TileIndex> wanted = trade(comm, requests_out, asked_tiles, requests_in, 1);

  std::vector<TileIndex> tiles = wanted;
  for (const TilePiece& piece : reach.mine)
    if (tiles.empty() || tiles.back() != piece.tile) tiles.push_back(piece.tile);
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  collective_guard(comm, [&] { owned_ = PoolLayout(grid, std::move(tiles), tile_width); });

  constexpr int n_columns = tile_width * tile_width;
  std::vector<LocalIndex> answers;  // the first node of each column of each tile wanted
  for (const TileIndex tile : wanted)
    for (int column = 0; column < n_columns; ++column) answers.push_back(index_in(owned_, owned_.slot(tile), column, 0));
  const std::vector<LocalIndex> places = trade(comm, requests_in, answers, requests_out, n_columns);

  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  std::size_t place = 0;
  for (std::size_t n = 0; n < reach.others.size(); ++n) {
    const TilePiece& piece = reach.others[n];
    if (n > 0 && (piece.rank != reach.others[n - 1].rank || piece.tile != reach.others[n - 1].tile)) ++place;
    const LocalIndex first = places[place * n_columns + static_cast<std::size_t>(piece.column)] + piece.z;
    for (LocalIndex m = 0; m < piece.count; ++m) {
      leaves.push_back(piece.pool + m);
      roots.push_back({piece.rank, first + m});
    }
  }
  BULKLEY_PETSC(PetscSFCreate(comm.get(), sf_.put()));
  BULKLEY_PETSC(PetscSFSetGraph(sf_.get(), owned_.n_nodes(), static_cast<PetscInt>(leaves.size()), leaves.data(),
                                PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  BULKLEY_PETSC(PetscSFSetUp(sf_.get()));

  PetscInt n_owners = 0, n_sharers = 0;
  const PetscInt *first_root = nullptr, *root = nullptr;
  BULKLEY_PETSC(PetscSFGetRootRanks(sf_.get(), &n_owners, nullptr, nullptr, nullptr, nullptr));
  BULKLEY_PETSC(PetscSFGetLeafRanks(sf_.get(), &n_sharers, nullptr, &first_root, &root));
  by_others_.assign(root, root + first_root[n_sharers]);
  sent_by_add_ = {leaves.size() * sizeof(Node), static_cast<int>(n_owners)};
  sent_by_get_ = {by_others_.size() * sizeof(Node), static_cast<int>(n_sharers)};

  std::vector<Piece> local;
  for (const TilePiece& piece : reach.mine) {
    const LocalIndex at = index_in(owned_, owned_.slot(piece.tile), piece.column, piece.z);
    if (!local.empty() && local.back().pool + local.back().count == piece.pool &&
        local.back().owned + local.back().count == at)
      local.back().count += piece.count;
    else
      local.push_back({piece.pool, at, piece.count});
  }
  const std::vector<LocalIndex> here = reach_locally(std::move(local));
  std::sort(by_others_.begin(), by_others_.end());
  by_others_.erase(std::unique(by_others_.begin(), by_others_.end()), by_others_.end());
  std::set_difference(by_others_.begin(), by_others_.end(), here.begin(), here.end(), std::back_inserter(only_others_));
  active_.resize(here.size() + only_others_.size());
  std::merge(here.begin(), here.end(), only_others_.begin(), only_others_.end(), active_.begin());
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

Exchange::~Exchange() {
  BULKLEY_MPI(MPI_Type_free(&node_type_));
  BULKLEY_MPI(MPI_Type_free(&pair_type_));
}

// Sums begin at +0 and thus never become -0: 0 + -0 is 0.
template <int n_numbers>
void Exchange::add_numbers(MPI_Datatype type, const double* pool, double* owned) {
  BULKLEY_PETSC(PetscSFReduceBegin(sf_.get(), type, pool, owned, MPI_SUM));
  for (const Piece& piece : first_) {
    const double* const from = numbers_of<n_numbers>(pool, piece.pool);
    double* const to = numbers_of<n_numbers>(owned, piece.owned);
    for (std::ptrdiff_t n = 0, end = std::ptrdiff_t{piece.count} * n_numbers; n < end; ++n) to[n] = 0.0 + from[n];
  }
  for (const LocalIndex n : only_others_) std::fill_n(numbers_of<n_numbers>(owned, n), n_numbers, 0.0);
  for (const Piece& piece : again_) {
    const double* const from = numbers_of<n_numbers>(pool, piece.pool);
    double* const to = numbers_of<n_numbers>(owned, piece.owned);
    for (std::ptrdiff_t n = 0, end = std::ptrdiff_t{piece.count} * n_numbers; n < end; ++n) to[n] += from[n];
  }
  const double begin = MPI_Wtime();
  BULKLEY_PETSC(PetscSFReduceEnd(sf_.get(), type, pool, owned, MPI_SUM));
  seconds_waiting_ += MPI_Wtime() - begin;
}

template <int n_numbers>
void Exchange::get_numbers(MPI_Datatype type, const double* owned, double* pool) {
  BULKLEY_PETSC(PetscSFBcastBegin(sf_.get(), type, owned, pool, MPI_REPLACE));
  for (const std::vector<Piece>* pieces : {&first_, &again_})
    for (const Piece& piece : *pieces)
      std::copy_n(numbers_of<n_numbers>(owned, piece.owned), std::ptrdiff_t{piece.count} * n_numbers,
                  numbers_of<n_numbers>(pool, piece.pool));
  for (const PoolPiece& piece : beyond_)
    std::fill_n(numbers_of<n_numbers>(pool, piece.pool), std::ptrdiff_t{piece.count} * n_numbers, 0.0);
  const double begin = MPI_Wtime();
  BULKLEY_PETSC(PetscSFBcastEnd(sf_.get(), type, owned, pool, MPI_REPLACE));
  seconds_waiting_ += MPI_Wtime() - begin;
}

// The nodes of other ranks come as pairs into an array of pairs, and are divided between the two arrays at the end.
void Exchange::add(const NodePair* pool, Node* motion, Node* change) {
  pairs_.resize(static_cast<std::size_t>(n_owned()));
  for (const LocalIndex n : by_others_) pairs_[static_cast<std::size_t>(n)] = {};
  BULKLEY_PETSC(PetscSFReduceBegin(sf_.get(), pair_type_, pool, pairs_.data(), MPI_SUM));
  const auto add_to = [](Node& node, const Node& other) {
    for (int c = 0; c < 4; ++c) node.c[c] += other.c[c];
  };
  for (const Piece& piece : first_)
    for (LocalIndex n = 0; n < piece.count; ++n) {
      motion[piece.owned + n] = change[piece.owned + n] = {};
      add_to(motion[piece.owned + n], pool[piece.pool + n].motion);
      add_to(change[piece.owned + n], pool[piece.pool + n].change);
    }
  for (const LocalIndex n : only_others_) motion[n] = change[n] = {};
  for (const Piece& piece : again_)
    for (LocalIndex n = 0; n < piece.count; ++n) {
      add_to(motion[piece.owned + n], pool[piece.pool + n].motion);
      add_to(change[piece.owned + n], pool[piece.pool + n].change);
    }
  const double begin = MPI_Wtime();
  BULKLEY_PETSC(PetscSFReduceEnd(sf_.get(), pair_type_, pool, pairs_.data(), MPI_SUM));
  seconds_waiting_ += MPI_Wtime() - begin;
  for (const LocalIndex n : by_others_) {
    add_to(motion[n], pairs_[static_cast<std::size_t>(n)].motion);
    add_to(change[n], pairs_[static_cast<std::size_t>(n)].change);
  }
}

void Exchange::get(const Node* motion, const Node* change, NodePair* pool) {
  pairs_.resize(static_cast<std::size_t>(n_owned()));
  for (const LocalIndex n : by_others_) pairs_[static_cast<std::size_t>(n)] = {motion[n], change[n]};
  BULKLEY_PETSC(PetscSFBcastBegin(sf_.get(), pair_type_, pairs_.data(), pool, MPI_REPLACE));
  for (const std::vector<Piece>* pieces : {&first_, &again_})
    for (const Piece& piece : *pieces)
      for (LocalIndex n = 0; n < piece.count; ++n) pool[piece.pool + n] = {motion[piece.owned + n], change[piece.owned + n]};
  for (const PoolPiece& piece : beyond_) std::fill_n(pool + piece.pool, piece.count, NodePair{});
  const double begin = MPI_Wtime();
  BULKLEY_PETSC(PetscSFBcastEnd(sf_.get(), pair_type_, pairs_.data(), pool, MPI_REPLACE));
  seconds_waiting_ += MPI_Wtime() - begin;
}

void Exchange::add(const Node* pool, Node* owned) { add_numbers<4>(node_type_, numbers(pool), numbers(owned)); }
void Exchange::add(const double* pool, double* owned) { add_numbers<1>(MPI_DOUBLE, pool, owned); }
void Exchange::get(const Node* owned, Node* pool) { get_numbers<4>(node_type_, numbers(owned), numbers(pool)); }
void Exchange::get(const double* owned, double* pool) { get_numbers<1>(MPI_DOUBLE, owned, pool); }

}  // namespace bulkley
