#pragma once
// The potential of a magnetic ball on a box of nodes, solved for and timed.

#include "magnetics/magnetics_settings.hpp"
#include "magnetostatics/petsc_potential.hpp"

namespace bulkley {

/// A ball of susceptibility 5 and a third of the box across in a uniform field, on `n_cells` cells along each axis; the potential is
/// zero at half a cell beyond the faces.
class FieldSolve {
 public:
  /// On one rank.
  FieldSolve(const Comm& comm, int n_cells);

  /// The operators of all levels from the permeabilities; the time, s.
  double prepare(FieldSolver solver);
  struct Timing {
    double seconds = 0.0;  ///< of one iteration
    int n_iterations = 0;
  };
  /// From nothing to a residual of 1e-8, by our solver or by PETSc's. Throws RunError where that is not reached.
  Timing solve(FieldSolver solver);

  std::size_t n_nodes() const { return right_.size(); }

 private:
  PotentialSolver own_;
  PetscPotential petsc_;
  std::vector<double> right_, solution_;
};

}  // namespace bulkley
