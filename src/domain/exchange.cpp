#include "bulkley/domain/exchange.hpp"

#include <algorithm>
#include <utility>

namespace bulkley {

namespace {

struct Piece {
  Int3 node;  // first node, in grid indices not yet wrapped
  LocalIndex pool;
  LocalIndex count;
};

// The rows of a layout, cut at multiples of the tile width, so that each piece has one owner and wraps nowhere inside. The
// pieces of 4 x 4 columns are ordered as owned nodes are, x fastest, while rows run along z: so both sides stay in cache.
std::vector<Piece> pieces_of(const PoolLayout& layout) {
  std::vector<Piece> pieces;
  pieces.reserve(static_cast<std::size_t>(layout.n_nodes()) / 3);
  const auto column_block = [](const NodeRow& row) { return std::pair(row.i / tile_width, row.j / tile_width); };
  const auto& rows = layout.rows();
  for (std::size_t r = 0; r < rows.size();) {
    const auto block = column_block(rows[r]);
    const auto first_of_block = static_cast<std::ptrdiff_t>(pieces.size());
    for (; r < rows.size() && column_block(rows[r]) == block; ++r) {
      const NodeRow& row = rows[r];
      for (int n = 0, count; n < row.count; n += count) {
        count = std::min(tile_width - (row.k + n) % tile_width, row.count - n);
        pieces.push_back({{row.i, row.j, row.k + n}, row.offset + n, count});
      }
    }
    std::stable_sort(pieces.begin() + first_of_block, pieces.end(), [](const Piece& a, const Piece& b) {
      return std::pair(a.node[2], a.node[1]) < std::pair(b.node[2], b.node[1]);
    });
  }
  return pieces;
}

}  // namespace

Exchange::Exchange(const Comm& comm, const Grid& grid, const PoolLayout& layout) {
  static_assert(sizeof(Node) == 4 * sizeof(double));
  BULKLEY_MPI(MPI_Type_contiguous(4, MPI_DOUBLE, &node_type_));
  BULKLEY_MPI(MPI_Type_commit(&node_type_));
  owned_plane_ = grid.count()[0] * grid.count()[1];

  // In the SF, leaves are pool nodes and roots are nodes of other ranks; who owns what is arithmetic, so nothing is
  // communicated to find it.
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  std::vector<int> neighbours;
  std::vector<bool> reached(grid.n_owned(), false);
  for (const Piece& piece : pieces_of(layout)) {
    LocalIndex n_inside = 0;
    while (n_inside < piece.count && grid.contains({piece.node[0], piece.node[1], piece.node[2] + n_inside})) ++n_inside;
    for (LocalIndex n = n_inside; n < piece.count; ++n) beyond_.push_back(piece.pool + n);
    if (n_inside == 0) continue;

    const Grid::Location first = grid.locate(piece.node);
    if (first.rank == comm.rank()) {
      local_.push_back({piece.pool, first.index, n_inside});
      for (LocalIndex n = 0; n < n_inside; ++n) reached[first.index + n * owned_plane_] = true;
      continue;
    }
    for (LocalIndex n = 0; n < n_inside; ++n) {
      const Grid::Location owner = grid.locate({piece.node[0], piece.node[1], piece.node[2] + n});
      leaves.push_back(piece.pool + n);
      roots.push_back({owner.rank, owner.index});
    }
    if (neighbours.empty() || neighbours.back() != first.rank) neighbours.push_back(first.rank);
  }
  bytes_remote_ = leaves.size() * sizeof(Node);
  std::sort(neighbours.begin(), neighbours.end());
  n_neighbours_ = static_cast<int>(std::unique(neighbours.begin(), neighbours.end()) - neighbours.begin());

  BULKLEY_PETSC(PetscSFCreate(comm.get(), sf_.put()));
  BULKLEY_PETSC(PetscSFSetGraph(sf_.get(), grid.n_owned(), static_cast<PetscInt>(leaves.size()), leaves.data(),
                                PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  BULKLEY_PETSC(PetscSFSetUp(sf_.get()));

  const PetscInt* degree = nullptr;
  BULKLEY_PETSC(PetscSFComputeDegreeBegin(sf_.get(), &degree));
  BULKLEY_PETSC(PetscSFComputeDegreeEnd(sf_.get(), &degree));
  for (LocalIndex n = 0; n < grid.n_owned(); ++n)
    if (reached[n] || degree[n] > 0) active_.push_back(n);
}

Exchange::~Exchange() { BULKLEY_MPI(MPI_Type_free(&node_type_)); }

void Exchange::add(const Node* pool, Node* owned) {
  for (const LocalPiece& piece : local_)
    for (LocalIndex n = 0; n < piece.count; ++n) {
      Node& sum = owned[piece.owned + n * owned_plane_];
      for (int c = 0; c < 4; ++c) sum.c[c] += pool[piece.pool + n].c[c];
    }
  BULKLEY_PETSC(PetscSFReduceBegin(sf_.get(), node_type_, pool, owned, MPI_SUM));
  BULKLEY_PETSC(PetscSFReduceEnd(sf_.get(), node_type_, pool, owned, MPI_SUM));
}

void Exchange::get(const Node* owned, Node* pool) {
  BULKLEY_PETSC(PetscSFBcastBegin(sf_.get(), node_type_, owned, pool, MPI_REPLACE));
  for (const LocalPiece& piece : local_)
    for (LocalIndex n = 0; n < piece.count; ++n) pool[piece.pool + n] = owned[piece.owned + n * owned_plane_];
  for (LocalIndex n : beyond_) pool[n] = Node{};
  BULKLEY_PETSC(PetscSFBcastEnd(sf_.get(), node_type_, owned, pool, MPI_REPLACE));
}

}  // namespace bulkley
