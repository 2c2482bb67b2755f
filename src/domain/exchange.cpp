#include "bulkley/domain/exchange.hpp"

#include <algorithm>
#include <iterator>

namespace bulkley {

Exchange::Exchange(const Comm& comm, const Grid& grid, const PoolLayout& layout) {
  static_assert(sizeof(Node) == 4 * sizeof(double));
  BULKLEY_MPI(MPI_Type_contiguous(4, MPI_DOUBLE, &node_type_));
  BULKLEY_MPI(MPI_Type_commit(&node_type_));

  // In the SF, leaves are pool nodes and roots are nodes of other ranks; who owns what is arithmetic, so nothing is
  // communicated to find it.
  std::vector<Piece> local;
  std::vector<PetscInt> leaves;
  std::vector<PetscSFNode> roots;
  for (const NodeRow& row : layout.rows())
    for (LocalIndex n = 0, count; n < row.count; n += count) {
      const Int3 node{row.i, row.j, row.k + n};
      const LocalIndex pool = row.offset + n;
      count = row.count - n;
      if (!grid.contains(node)) {  // nor the nodes above it
        beyond_.push_back({pool, count});
        continue;
      }
      const Grid::Location at = grid.locate(node);
      count = std::min(count, at.n_run);
      if (at.rank == comm.rank()) {
        local.push_back({pool, at.index, count});
        continue;
      }
      for (LocalIndex m = 0; m < count; ++m) {
        leaves.push_back(pool + m);
        roots.push_back({at.rank, at.index + m});
      }
    }

  BULKLEY_PETSC(PetscSFCreate(comm.get(), sf_.put()));
  BULKLEY_PETSC(PetscSFSetGraph(sf_.get(), grid.n_owned(), static_cast<PetscInt>(leaves.size()), leaves.data(),
                                PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  BULKLEY_PETSC(PetscSFSetUp(sf_.get()));

  PetscInt n_owners = 0, n_sharers = 0;
  const PetscInt *first_root = nullptr, *root = nullptr;
  BULKLEY_PETSC(PetscSFGetRootRanks(sf_.get(), &n_owners, nullptr, nullptr, nullptr, nullptr));
  BULKLEY_PETSC(PetscSFGetLeafRanks(sf_.get(), &n_sharers, nullptr, &first_root, &root));
  std::vector<LocalIndex> by_others(root, root + first_root[n_sharers]);
  sent_by_add_ = {leaves.size() * sizeof(Node), static_cast<int>(n_owners)};
  sent_by_get_ = {by_others.size() * sizeof(Node), static_cast<int>(n_sharers)};

  const std::vector<LocalIndex> here = reach_locally(std::move(local));
  std::sort(by_others.begin(), by_others.end());
  by_others.erase(std::unique(by_others.begin(), by_others.end()), by_others.end());
  std::set_difference(by_others.begin(), by_others.end(), here.begin(), here.end(), std::back_inserter(only_others_));
  active_.resize(here.size() + only_others_.size());
  std::merge(here.begin(), here.end(), only_others_.begin(), only_others_.end(), active_.begin());
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

Exchange::~Exchange() { BULKLEY_MPI(MPI_Type_free(&node_type_)); }

// Sums begin at +0 and thus never become -0: 0 + -0 is 0.
void Exchange::add(const Node* pool, Node* owned) {
  BULKLEY_PETSC(PetscSFReduceBegin(sf_.get(), node_type_, pool, owned, MPI_SUM));
  for (const Piece& piece : first_)
    for (LocalIndex n = 0; n < piece.count; ++n)
      for (int c = 0; c < 4; ++c) owned[piece.owned + n].c[c] = 0.0 + pool[piece.pool + n].c[c];
  for (const LocalIndex n : only_others_) owned[n] = Node{};
  for (const Piece& piece : again_)
    for (LocalIndex n = 0; n < piece.count; ++n)
      for (int c = 0; c < 4; ++c) owned[piece.owned + n].c[c] += pool[piece.pool + n].c[c];
  const double begin = MPI_Wtime();
  BULKLEY_PETSC(PetscSFReduceEnd(sf_.get(), node_type_, pool, owned, MPI_SUM));
  seconds_waiting_ += MPI_Wtime() - begin;
}

void Exchange::get(const Node* owned, Node* pool) {
  BULKLEY_PETSC(PetscSFBcastBegin(sf_.get(), node_type_, owned, pool, MPI_REPLACE));
  for (const std::vector<Piece>* pieces : {&first_, &again_})
    for (const Piece& piece : *pieces) std::copy_n(owned + piece.owned, piece.count, pool + piece.pool);
  for (const PoolPiece& piece : beyond_) std::fill_n(pool + piece.pool, piece.count, Node{});
  const double begin = MPI_Wtime();
  BULKLEY_PETSC(PetscSFBcastEnd(sf_.get(), node_type_, owned, pool, MPI_REPLACE));
  seconds_waiting_ += MPI_Wtime() - begin;
}

}  // namespace bulkley
