#include "bench/field_solve.hpp"

#include <algorithm>

namespace bulkley {

namespace {

constexpr double susceptibility = 5.0;

FieldLayout cube(int n_cells) {
  LevelShape shape;
  shape.n_nodes = {n_cells + 1, n_cells + 1, n_cells + 1};
  FieldLayout layout = coarse_layout(shape);
  layout.geometry.cell_size = 1.0;
  return layout;
}

// The flux through the faces of a box whose potential is zero half a cell outside.
void set_leaks(FieldLevel& level) {
  const LevelShape& shape = level.shape();
  const NodeBox& box = level.owned();
  for_rows(box, [&](int i, int j) {
    for (int k = 0; k < box.count[2]; ++k) {
      const Int3 n{i, j, k};
      double area = 0.0;
      for (int axis = 0; axis < 3; ++axis)
        if (shape.share(axis, n[static_cast<std::size_t>(axis)]) < 1.0)
          area += shape.share_across(axis, n) * shape.spacing[(axis + 1) % 3] * shape.spacing[(axis + 2) % 3];
      level.leak[static_cast<std::size_t>(box.index(n))] = 2.0 * area;
    }
  });
}

// Of a node, by how far it is inside the ball: partly filled ones as dilutions of spheres.
double permeability(const Int3& n, int n_cells) {
  const double middle = 0.5 * n_cells, radius = n_cells / 6.0;
  const double distance = Vec3(n[0] - middle, n[1] - middle, n[2] - middle).norm();
  const double content = std::clamp(radius - distance + 0.5, 0.0, 1.0);
  return 1.0 + content * susceptibility / (1.0 + (1.0 - content) * susceptibility / 3.0);
}

}  // namespace

FieldSolve::FieldSolve(const Comm& comm, int n_cells) : own_(comm, cube(n_cells), set_leaks, false), petsc_(own_, "") {
  const NodeBox &owned = own_.finest().owned(), &ghosted = own_.finest().ghosted();
  right_.assign(owned.size(), 0.0);
  solution_.assign(owned.size(), 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const std::span<double> edges = own_.edges(axis);
    for_rows(owned, [&](int i, int j) {
      for (int k = 0; k < owned.count[2]; ++k) {
        const Int3 n{i, j, k};
        Int3 next = n;
        if (++next[static_cast<std::size_t>(axis)] > n_cells) continue;
        const double here = permeability(n, n_cells), there = permeability(next, n_cells);
        const double edge = 2.0 * here * there / (here + there);
        edges[static_cast<std::size_t>(ghosted.index(n))] = edge;
        if (axis > 0) continue;  // the field is along x
        right_[static_cast<std::size_t>(owned.index(n))] -= edge - 1.0;
        right_[static_cast<std::size_t>(owned.index(next))] += edge - 1.0;
      }
    });
  }
  own_.prepare();
  petsc_.prepare();
}

double FieldSolve::prepare(FieldSolver solver) {
  const double begin = MPI_Wtime();
  solver == FieldSolver::own ? own_.prepare() : petsc_.prepare();
  return MPI_Wtime() - begin;
}

FieldSolve::Timing FieldSolve::solve(FieldSolver solver) {
  std::ranges::fill(solution_, 0.0);
  const double begin = MPI_Wtime();
  const PotentialReport report =
      solver == FieldSolver::own ? own_.solve(right_, 1e-8, 100, solution_) : petsc_.solve(right_, 1e-8, 100, solution_);
  if (!report.solved) throw RunError("the potential of the ball is not found in 100 iterations");
  return {(MPI_Wtime() - begin) / report.n_iterations, report.n_iterations};
}

}  // namespace bulkley
