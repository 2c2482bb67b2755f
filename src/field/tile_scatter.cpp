#include "field/tile_scatter.hpp"

#include <algorithm>

namespace bulkley {

TileScatter::TileScatter(const Comm& comm, const Exchange& exchange, const FieldGrid& field) : field_size_(field.size()) {
  BULKLEY_MPI(MPI_Type_contiguous(field.n_components(), MPI_DOUBLE, &node_type_));
  BULKLEY_MPI(MPI_Type_commit(&node_type_));
  const auto active = exchange.active_nodes();
  std::vector<PetscInt> leaves(active.begin(), active.end());
  std::vector<PetscSFNode> roots;
  roots.reserve(leaves.size());
  for (const Int3& node : exchange.active_positions()) {
    const FieldGrid::Location at = field.locate(node);
    roots.push_back({at.rank, at.index});
  }
  BULKLEY_PETSC(PetscSFCreate(comm.get(), sf_.put()));
  BULKLEY_PETSC(PetscSFSetGraph(sf_.get(), field.n_owned(), static_cast<PetscInt>(leaves.size()), leaves.data(),
                                PETSC_COPY_VALUES, roots.data(), PETSC_COPY_VALUES));
  BULKLEY_PETSC(PetscSFSetUp(sf_.get()));
}

TileScatter::~TileScatter() { BULKLEY_MPI(MPI_Type_free(&node_type_)); }

void TileScatter::to_field(const double* owned, double* field) const {
  std::fill_n(field, field_size_, 0.0);
  BULKLEY_PETSC(PetscSFReduceBegin(sf_.get(), node_type_, owned, field, MPI_REPLACE));
  BULKLEY_PETSC(PetscSFReduceEnd(sf_.get(), node_type_, owned, field, MPI_REPLACE));
}

void TileScatter::to_owned(const double* field, double* owned) const {
  BULKLEY_PETSC(PetscSFBcastBegin(sf_.get(), node_type_, field, owned, MPI_REPLACE));
  BULKLEY_PETSC(PetscSFBcastEnd(sf_.get(), node_type_, field, owned, MPI_REPLACE));
}

}  // namespace bulkley
