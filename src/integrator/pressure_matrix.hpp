#pragma once
// The matrix of the pressure system, entry by entry, for solvers that need it (docs/theory.md, "Implicit pressure").
//
// With G = dt B T P M^-1/2 over the nodes that are no images, (I5) is A + G G^T + Z: a row holds the cells that share a node with
// its cell, directly or through a mirror, 125 of them inside a body.

#include <petscsys.h>

#include <array>
#include <span>
#include <vector>

#include "distribution/cell_grid.hpp"
#include "integrator/pressure_contact.hpp"
#include "kernel/pressure_cells.hpp"

namespace bulkley {

/// The rows of a sparse matrix that this rank holds; they follow those of the ranks before it.
struct SparseRows {
  std::vector<PetscInt> first;   ///< by row, then the end: where its entries begin
  std::vector<PetscInt> column;  ///< among the rows of all ranks
  std::vector<double> value;
};

/// What (I5) is made of, with the constraints of the present round and the cells that have parted.
struct PressureTerms {
  double dt;
  const PressureRows& rows;
  const PressureContact& contact;
  std::span<const double> scale;    ///< 1/m by node, 0 where it is empty
  std::span<const LocalIndex> own;  ///< numbers of this rank's cells; what follows is by place in it, but for `block_volume`
  std::span<const double> volume, compliance;
  std::span<const double> within_block;  ///< Z of pressures that differ from the mean of the block, m^3/Pa
  std::span<const LocalIndex> block_of;
  std::span<const double> block_volume;  ///< m^3, by block
  std::span<const char> parted;
};

class PressureMatrix {
 public:
  /// Numbers the rows: this rank's cells in their order, after those of the ranks before it. `n_cells`: that it knows of.
  /// Collective.
  void number_rows(const Comm& comm, CellHalo& halo, std::span<const LocalIndex> own, LocalIndex n_cells);
  /// Of all ranks.
  GlobalIndex n_rows() const { return n_rows_; }

  /// The rows of this rank. Of a cell that has parted, row and column keep their diagonal alone. Valid until the next call.
  /// Collective.
  const SparseRows& assemble(const Comm& comm, CellHalo& halo, const PressureTerms& terms);

  std::size_t memory() const;

 private:
  /// A cell's row of G at one node.
  struct Entry {
    LocalIndex cell, node;
    double c[3];
  };
  void fill_entries(const PressureTerms& terms);
  void group_by_block(const PressureTerms& terms);
  void sum_row(const PressureTerms& terms, std::size_t k);
  void add(LocalIndex cell, double value);

  GlobalIndex n_rows_ = 0;
  std::vector<PetscInt> row_of_;                   // by cell
  std::vector<Entry> entries_;                     // of all cells, ordered by node
  std::vector<std::size_t> first_;                 // in entries_, by node, then the end
  std::vector<std::size_t> place_;                 // in entries_, by entry of B
  std::vector<std::array<LocalIndex, 8>> blocks_;  // places in `own` of the cells of each block; -1: none
  std::vector<double> sums_;                       // the row being assembled, by cell
  std::vector<char> is_in_row_;
  std::vector<LocalIndex> in_row_;
  SparseRows rows_;
};

}  // namespace bulkley
