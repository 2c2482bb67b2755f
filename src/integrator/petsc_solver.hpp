#pragma once
// PETSc's iterative solvers (KSP) for the pressure system, as the options of a scene choose them. Sums over ranks run in MPI's
// order, and preconditioners depend on who holds which row: results depend on the ranks, at the tolerance.

#include <petscksp.h>

#include <span>
#include <string>
#include <vector>

#include "integrator/pressure_matrix.hpp"
#include "parallel/petsc_options.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

/// When a solution is good enough: sum of weight r^2 over all rows is at most `goal`. The first `least_iterations` are taken
/// unless it is at most `rounding`.
struct PetscGoal {
  double goal, rounding;
  int least_iterations;
};

struct PetscOutcome {
  int n_iterations = 0;
  std::string fault;  ///< the reason that PETSc gives, where the goal was not reached
};

class PetscSolver {
 public:
  /// `comm` must outlive this. Collective.
  PetscSolver(const Comm& comm, const PressureSettings& settings);

  /// A symmetric positive definite matrix, of at least one row in all, and a preconditioner made of it. Collective.
  void set_matrix(const SparseRows& rows);
  /// Another matrix with as many rows; the preconditioner stays. Collective.
  void change_matrix(const SparseRows& rows);

  /// Solves for `solution`, which it starts from; all three by row of this rank. The same outcome on every rank. Collective.
  PetscOutcome solve(const PetscGoal& goal, std::span<const double> right, std::span<const double> weight,
                     std::span<double> solution);

  /// Those of the scene.
  const OptionsHandle& options() const { return options_; }

 private:
  using MatHandle = PetscHandle<Mat, MatDestroy>;
  using KspHandle = PetscHandle<KSP, KSPDestroy>;
  using VecHandle = PetscHandle<Vec, VecDestroy>;

  void create_matrix(const SparseRows& rows);

  const Comm& comm_;
  int max_iterations_;
  OptionsHandle options_;  // these alone are in force in the solver
  MatHandle matrix_;
  KspHandle solver_;
  VecHandle right_, solution_, weight_, residual_, scratch_;
};

/// Throws UsageError, alike on every rank, where the scene's options for PETSc are not understood: by a trial of the solver on
/// a small system. Nothing to do with other solvers. Collective.
void check_petsc_options(const Comm& comm, const PressureSettings& settings);

}  // namespace bulkley
