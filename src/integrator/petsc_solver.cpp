#include "integrator/petsc_solver.hpp"

#include <algorithm>
#include <cmath>

namespace bulkley {

namespace {

struct Test {
  const PetscGoal& goal;
  Vec weight, residual, scratch;
};

// Our measure of the residual in place of PETSc's, which depends on the preconditioner.
PetscErrorCode test_residual(KSP solver, PetscInt n, PetscReal, KSPConvergedReason* reason, void* context) {
  const Test& test = *static_cast<const Test*>(context);
  Vec residual = nullptr;
  PetscScalar square = 0.0;
  BULKLEY_PETSC(KSPBuildResidual(solver, test.scratch, test.residual, &residual));
  BULKLEY_PETSC(VecPointwiseMult(test.scratch, test.weight, residual));
  BULKLEY_PETSC(VecDot(test.scratch, residual, &square));
  *reason = KSP_CONVERGED_ITERATING;
  if (!std::isfinite(square))
    *reason = KSP_DIVERGED_NANORINF;
  else if (square <= (n < test.goal.least_iterations ? test.goal.rounding : test.goal.goal))
    *reason = KSP_CONVERGED_RTOL;
  return 0;
}

void copy_in(std::span<const double> from, Vec to) {
  PetscScalar* values = nullptr;
  BULKLEY_PETSC(VecGetArrayWrite(to, &values));
  std::ranges::copy(from, values);
  BULKLEY_PETSC(VecRestoreArrayWrite(to, &values));
}

void copy_out(Vec from, std::span<double> to) {
  const PetscScalar* values = nullptr;
  BULKLEY_PETSC(VecGetArrayRead(from, &values));
  std::copy_n(values, to.size(), to.begin());
  BULKLEY_PETSC(VecRestoreArrayRead(from, &values));
}

}  // namespace

PetscSolver::PetscSolver(const Comm& comm, const PressureSettings& settings)
    : comm_(comm), max_iterations_(settings.max_iterations), options_(petsc_options_of(settings.petsc_options)) {}

void PetscSolver::create_matrix(const SparseRows& rows) {
  const auto n = static_cast<PetscInt>(rows.first.size() - 1);
  const PetscInt *const first = rows.first.data(), *const column = rows.column.data();
  Mat* const matrix = matrix_.put();
  BULKLEY_PETSC(MatCreate(comm_.get(), matrix));
  BULKLEY_PETSC(MatSetSizes(*matrix, n, n, PETSC_DETERMINE, PETSC_DETERMINE));
  BULKLEY_PETSC(MatSetType(*matrix, MATAIJ));
  BULKLEY_PETSC(MatSeqAIJSetPreallocationCSR(*matrix, first, column, rows.value.data()));
  BULKLEY_PETSC(MatMPIAIJSetPreallocationCSR(*matrix, first, column, rows.value.data()));
  BULKLEY_PETSC(MatSetOption(*matrix, MAT_SPD, PETSC_TRUE));
}

void PetscSolver::set_matrix(const SparseRows& rows) {
  const OptionsInForce options(options_);
  create_matrix(rows);
  BULKLEY_PETSC(MatCreateVecs(matrix_.get(), solution_.put(), right_.put()));
  for (VecHandle* vector : {&weight_, &residual_, &scratch_}) BULKLEY_PETSC(VecDuplicate(right_.get(), vector->put()));

  KSP* const solver = solver_.put();
  PC preconditioner = nullptr;
  BULKLEY_PETSC(KSPCreate(comm_.get(), solver));
  BULKLEY_PETSC(KSPSetOptionsPrefix(*solver, petsc_pressure_prefix + 1));
  BULKLEY_PETSC(KSPSetType(*solver, KSPCG));
  BULKLEY_PETSC(KSPGetPC(*solver, &preconditioner));
  BULKLEY_PETSC(PCSetType(preconditioner, PCGAMG));
  BULKLEY_PETSC(KSPSetOperators(*solver, matrix_.get(), matrix_.get()));
  BULKLEY_PETSC(KSPSetFromOptions(*solver));
  BULKLEY_PETSC(KSPSetInitialGuessNonzero(*solver, PETSC_TRUE));
  BULKLEY_PETSC(KSPSetTolerances(*solver, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, max_iterations_));
  BULKLEY_PETSC(KSPSetUp(*solver));
}

void PetscSolver::change_matrix(const SparseRows& rows) {
  create_matrix(rows);
  BULKLEY_PETSC(KSPSetReusePreconditioner(solver_.get(), PETSC_TRUE));
  BULKLEY_PETSC(KSPSetOperators(solver_.get(), matrix_.get(), matrix_.get()));
}

PetscOutcome PetscSolver::solve(const PetscGoal& goal, std::span<const double> right, std::span<const double> weight,
                                std::span<double> solution) {
  const OptionsInForce options(options_);
  copy_in(right, right_.get());
  copy_in(weight, weight_.get());
  copy_in(solution, solution_.get());
  Test test{goal, weight_.get(), residual_.get(), scratch_.get()};
  BULKLEY_PETSC(KSPSetConvergenceTest(solver_.get(), test_residual, &test, nullptr));
  BULKLEY_PETSC(KSPSolve(solver_.get(), right_.get(), solution_.get()));
  copy_out(solution_.get(), solution);
  PetscOutcome outcome;
  PetscInt n_iterations = 0;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  BULKLEY_PETSC(KSPGetIterationNumber(solver_.get(), &n_iterations));
  BULKLEY_PETSC(KSPGetConvergedReason(solver_.get(), &reason));
  outcome.n_iterations = static_cast<int>(n_iterations);
  if (reason <= 0) outcome.fault = KSPConvergedReasons[reason];
  return outcome;
}

namespace {

// Of the Laplacian on a cube, in slices along its first axis: large enough for a hierarchy of levels.
SparseRows trial_matrix(const Comm& comm) {
  constexpr int n = 12;
  const EvenShare rows = even_share(comm, n * n * n);
  SparseRows matrix{{0}, {}, {}};
  for (GlobalIndex row = rows.first; row < rows.end; ++row) {
    const auto add = [&](GlobalIndex column, double value) {
      matrix.column.push_back(static_cast<PetscInt>(column));
      matrix.value.push_back(value);
    };
    add(row, 6.0);
    for (const GlobalIndex stride : {GlobalIndex{1}, GlobalIndex{n}, GlobalIndex{n * n}}) {
      const GlobalIndex place = row / stride % n;
      if (place > 0) add(row - stride, -1.0);
      if (place < n - 1) add(row + stride, -1.0);
    }
    matrix.first.push_back(static_cast<PetscInt>(matrix.column.size()));
  }
  return matrix;
}

}  // namespace

void check_petsc_options(const Comm& comm, const PressureSettings& settings) {
  constexpr const char* key = "time.pressure.petsc_options";
  refuse_stray_options(petsc_pressure_prefix, "the pressure's solver", key);
  if (settings.solver != PressureSolver::petsc) return;
  PetscSolver solver(comm, settings);
  const SparseRows rows = trial_matrix(comm);
  const std::vector<double> ones(rows.first.size() - 1, 1.0);
  std::vector<double> solution(ones.size(), 0.0);
  try_petsc_options(key, solver.options(), [&] {
    solver.set_matrix(rows);
    solver.solve({1e-6, 0.0, 0}, ones, ones, solution);
  });
}

}  // namespace bulkley
