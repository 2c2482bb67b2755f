#include "magnetostatics/petsc_potential.hpp"

#include <algorithm>
#include <cmath>

#include "magnetics/magnetics_settings.hpp"

namespace bulkley {

namespace {

struct Test {
  double goal;
  Vec residual, scratch;
  double found = 0.0;
};

// The largest entry of the residual, in place of PETSc's norm, which depends on the preconditioner.
PetscErrorCode test_residual(KSP solver, PetscInt, PetscReal, KSPConvergedReason* reason, void* context) {
  Test& test = *static_cast<Test*>(context);
  Vec residual = nullptr;
  BULKLEY_PETSC(KSPBuildResidual(solver, test.scratch, test.residual, &residual));
  BULKLEY_PETSC(VecNorm(residual, NORM_INFINITY, &test.found));
  *reason = !std::isfinite(test.found) ? KSP_DIVERGED_NANORINF
            : test.found <= test.goal  ? KSP_CONVERGED_RTOL
                                       : KSP_CONVERGED_ITERATING;
  return 0;
}

// Two Chebyshev-Jacobi steps on all levels but the coarsest, 0, which every rank solves for itself.
void set_levels(PC multigrid, const PotentialSolver& own) {
  const int n_levels = own.n_levels();
  BULKLEY_PETSC(PCSetType(multigrid, PCMG));
  BULKLEY_PETSC(PCMGSetLevels(multigrid, n_levels, nullptr));
  BULKLEY_PETSC(PCMGSetGalerkin(multigrid, PC_MG_GALERKIN_BOTH));
  PC preconditioner = nullptr;
  for (int n = 1; n < n_levels; ++n) {
    PetscHandle<Mat, MatDestroy> interpolation;
    KSP smoother = nullptr;
    BULKLEY_PETSC(DMCreateInterpolation(own.level(n_levels - n).grid().dm(), own.level(n_levels - n - 1).grid().dm(),
                                        interpolation.put(), nullptr));
    BULKLEY_PETSC(PCMGSetInterpolation(multigrid, n, interpolation.get()));
    BULKLEY_PETSC(PCMGGetSmoother(multigrid, n, &smoother));
    BULKLEY_PETSC(KSPSetType(smoother, KSPCHEBYSHEV));
    BULKLEY_PETSC(KSPGetPC(smoother, &preconditioner));
    BULKLEY_PETSC(PCSetType(preconditioner, PCJACOBI));
  }
  KSP coarsest = nullptr, inner = nullptr;
  BULKLEY_PETSC(PCMGGetCoarseSolve(multigrid, &coarsest));
  BULKLEY_PETSC(KSPSetType(coarsest, KSPPREONLY));
  BULKLEY_PETSC(KSPGetPC(coarsest, &preconditioner));
  BULKLEY_PETSC(PCSetType(preconditioner, PCREDUNDANT));
  BULKLEY_PETSC(PCRedundantGetKSP(preconditioner, &inner));
  BULKLEY_PETSC(KSPGetPC(inner, &preconditioner));
  BULKLEY_PETSC(PCSetType(preconditioner, PCLU));
  if (own.singular()) BULKLEY_PETSC(PCFactorSetShiftType(preconditioner, MAT_SHIFT_NONZERO));
}

}  // namespace

void PetscPotential::create() {
  const FieldGrid& grid = own_.finest().grid();
  for (VecHandle* vector : {&right_, &solution_, &residual_, &scratch_}) *vector = grid.create_global();
  BULKLEY_PETSC(DMSetMatrixPreallocateOnly(grid.dm(), PETSC_TRUE));  // seven of the stencil's 27 entries are used
  BULKLEY_PETSC(DMCreateMatrix(grid.dm(), matrix_.put()));
  BULKLEY_PETSC(MatSetOption(matrix_.get(), MAT_SYMMETRIC, PETSC_TRUE));
  BULKLEY_PETSC(MatSetOption(matrix_.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  if (own_.singular()) {
    BULKLEY_PETSC(MatNullSpaceCreate(grid.comm().get(), PETSC_TRUE, 0, nullptr, constants_.put()));
    BULKLEY_PETSC(MatSetNullSpace(matrix_.get(), constants_.get()));
  }
  PC multigrid = nullptr;
  BULKLEY_PETSC(KSPCreate(grid.comm().get(), solver_.put()));
  BULKLEY_PETSC(KSPSetOptionsPrefix(solver_.get(), petsc_magnetics_prefix + 1));
  BULKLEY_PETSC(KSPSetType(solver_.get(), KSPCG));
  BULKLEY_PETSC(KSPGetPC(solver_.get(), &multigrid));
  set_levels(multigrid, own_);
  BULKLEY_PETSC(KSPSetFromOptions(solver_.get()));
  BULKLEY_PETSC(KSPSetInitialGuessNonzero(solver_.get(), PETSC_TRUE));
}

void PetscPotential::prepare() {
  const OptionsInForce in_force(options_);
  if (!solver_) create();
  const FieldLevel& level = own_.finest();
  const NodeBox &owned = level.owned(), &ghosted = level.ghosted();  // PETSc's local numbers are places in `ghosted`
  BULKLEY_PETSC(MatZeroEntries(matrix_.get()));
  for_rows(owned, [&](int i, int j) {
    for (int k = owned.first[2]; k < owned.first[2] + owned.count[2]; ++k) {
      const std::ptrdiff_t at = ghosted.index(i, j, k);
      const auto row = static_cast<PetscInt>(at);
      std::array<PetscInt, 7> columns{row};
      std::array<double, 7> values{level.leak[static_cast<std::size_t>(owned.index(i, j, k))]};
      PetscInt n = 1;
      for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
          const std::ptrdiff_t stride = ghosted.stride(axis);
          const double conductance =
              level.conductance[static_cast<std::size_t>(axis)][static_cast<std::size_t>(side < 0 ? at - stride : at)];
          if (conductance == 0.0) continue;  // beyond the box
          values[0] += conductance;
          columns[static_cast<std::size_t>(n)] = static_cast<PetscInt>(at + side * stride);
          values[static_cast<std::size_t>(n++)] = -conductance;
        }
      BULKLEY_PETSC(MatSetValuesLocal(matrix_.get(), 1, &row, n, columns.data(), values.data(), ADD_VALUES));
    }
  });
  BULKLEY_PETSC(MatAssemblyBegin(matrix_.get(), MAT_FINAL_ASSEMBLY));
  BULKLEY_PETSC(MatAssemblyEnd(matrix_.get(), MAT_FINAL_ASSEMBLY));
  BULKLEY_PETSC(KSPSetOperators(solver_.get(), matrix_.get(), matrix_.get()));
  BULKLEY_PETSC(KSPSetUp(solver_.get()));
}

PotentialReport PetscPotential::solve(std::span<const double> right, double tolerance, int max_iterations,
                                      std::span<double> solution) {
  const OptionsInForce in_force(options_);
  const auto copy = [](std::span<const double> from, Vec to) {
    PetscScalar* values = nullptr;
    BULKLEY_PETSC(VecGetArrayWrite(to, &values));
    std::ranges::copy(from, values);
    BULKLEY_PETSC(VecRestoreArrayWrite(to, &values));
  };
  copy(right, right_.get());
  copy(solution, solution_.get());
  double size = 0.0;
  BULKLEY_PETSC(VecNorm(right_.get(), NORM_INFINITY, &size));
  if (size == 0.0) {
    std::ranges::fill(solution, 0.0);
    return {};
  }
  Test test{tolerance * size, residual_.get(), scratch_.get()};
  BULKLEY_PETSC(KSPSetTolerances(solver_.get(), PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, max_iterations));
  BULKLEY_PETSC(KSPSetConvergenceTest(solver_.get(), test_residual, &test, nullptr));
  BULKLEY_PETSC(KSPSolve(solver_.get(), right_.get(), solution_.get()));

  PetscInt n_iterations = 0;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  BULKLEY_PETSC(KSPGetIterationNumber(solver_.get(), &n_iterations));
  BULKLEY_PETSC(KSPGetConvergedReason(solver_.get(), &reason));
  const PetscScalar* values = nullptr;
  BULKLEY_PETSC(VecGetArrayRead(solution_.get(), &values));
  std::copy_n(values, solution.size(), solution.begin());
  BULKLEY_PETSC(VecRestoreArrayRead(solution_.get(), &values));
  return {static_cast<int>(n_iterations), test.found / size, reason > 0};
}

std::size_t PetscPotential::memory() const {
  return static_cast<std::size_t>(bytes_per_node * static_cast<double>(own_.finest().owned().size()));
}

void check_petsc_options(const Comm& comm, const MagneticsSettings& settings) {
  constexpr const char* key = "magnetics.petsc_options";
  refuse_stray_options(petsc_magnetics_prefix, "the magnetic field's solver", key);
  if (settings.solver != FieldSolver::petsc) return;
  LevelShape shape;
  shape.n_nodes = {17, 17, 17};
  FieldLayout layout = coarse_layout(shape);
  layout.geometry.cell_size = 1.0;
  const auto leaks = [](FieldLevel& level) { std::ranges::fill(level.leak, 1.0); };
  PotentialSolver own(comm, layout, leaks, false);
  collective_guard(comm, [&] {  // it communicates, but fails on all ranks with nodes alike
    if (!own.has_nodes()) return;
    for (int axis = 0; axis < 3; ++axis) std::ranges::fill(own.edges(axis), 1.0);
    own.prepare();
    const std::vector<double> right(own.finest().owned().size(), 1.0);
    std::vector<double> solution(right.size(), 0.0);
    PetscPotential solver(own, settings.petsc_options);
    try_petsc_options(key, solver.options(), [&] {
      solver.prepare();
      solver.solve(right, 1e-6, 100, solution);
    });
  });
}

}  // namespace bulkley
