#pragma once
// Potentials by PETSc: the systems of PotentialSolver by other means, to check it. Sums over ranks run in MPI's order: results depend
// on the ranks, at the tolerance.

#include <petscksp.h>

#include <span>
#include <string>
#include <vector>

#include "magnetostatics/potential_solver.hpp"
#include "parallel/petsc_options.hpp"

namespace bulkley {

struct MagneticsSettings;

/// KSPCG with PCMG on the levels of a PotentialSolver: the finest matrix entry by entry, trilinear interpolation, coarse matrices as
/// products with it (Galerkin), two Chebyshev-Jacobi steps before and after, the coarsest level solved on each rank.
class PetscPotential {
 public:
  /// `own`: its levels, and the operator of the finest as it prepares it; must outlive this. `options`: in force in this solver alone.
  /// Not collective.
  PetscPotential(const PotentialSolver& own, const std::string& options) : own_(own), options_(petsc_options_of(options)) {}

  /// Takes the operator and sets up the levels. Collective over the ranks with nodes.
  void prepare();
  /// As PotentialSolver::solve. Collective over the ranks with nodes.
  PotentialReport solve(std::span<const double> right, double tolerance, int max_iterations, std::span<double> solution);

  const OptionsHandle& options() const { return options_; }
  /// Of the finest level, as measured: its matrix, the coarse ones, what their products keep for the next matrix, vectors.
  static constexpr double bytes_per_node = 720.0;
  std::size_t memory() const;

 private:
  using MatHandle = PetscHandle<Mat, MatDestroy>;
  using KspHandle = PetscHandle<KSP, KSPDestroy>;
  using NullSpaceHandle = PetscHandle<MatNullSpace, MatNullSpaceDestroy>;

  void create();

  const PotentialSolver& own_;
  OptionsHandle options_;
  MatHandle matrix_;
  NullSpaceHandle constants_;  // where the operator is singular
  KspHandle solver_;
  VecHandle right_, solution_, residual_, scratch_;
};

/// Throws UsageError, alike on every rank, where the scene's options for PETSc are not understood: by a trial on a small box.
/// Collective.
void check_petsc_options(const Comm& comm, const MagneticsSettings& settings);

}  // namespace bulkley
