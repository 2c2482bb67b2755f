#pragma once
// Potentials on a box of nodes: conjugate gradients with a multigrid cycle, whose arithmetic is the same on any number of ranks.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "magnetostatics/field_level.hpp"

namespace bulkley {

/// A level's axis is divided further while its number of cells is even and more than this.
inline constexpr int fewest_coarse_cells = 4;

/// How a solution went. The same on every rank with nodes.
struct PotentialReport {
  int n_iterations = 0;
  double residual = 0.0;  ///< largest of a node, over that of the right side
  bool solved = true;
};

/// The levels of a box of nodes, finest first: axes are halved while that gives whole cells and more than a few. Not collective.
std::vector<LevelShape> level_shapes(const FieldLayout& finest);

/// Solves A phi = b on the finest of several levels, A by edges with a permeability between each node and the next (FieldLevel). The
/// preconditioner is one V-cycle: two Chebyshev-Jacobi steps before and after, trilinear prolongation and its transpose, coarse
/// permeabilities by harmonic means in line and averages across; its vectors and coefficients are in single precision. No arithmetic
/// depends on how nodes are divided: the smoother's bounds are fixed (a seven-point operator's D^-1 A has no eigenvalue above 2), dot
/// products are order-free, and a residual is judged by its largest entry.
class PotentialSolver {
 public:
  /// Sets the leaks of a level, which are those of its boundary.
  using Leaks = std::function<void(FieldLevel&)>;

  /// `finest`: its cells along an axis should be even in number, and so on for coarser levels. `singular`: nothing leaks, so that
  /// the potential is found with the mean zero. Throws UsageError where PETSc cannot number the nodes. Collective.
  PotentialSolver(const Comm& comm, const FieldLayout& finest, const Leaks& leaks, bool singular);

  /// Whether this rank has nodes; others may not prepare and solve.
  bool has_nodes() const { return finest().grid().has_nodes(); }
  /// From the finest, 0, to the coarsest.
  const FieldLevel& level(int n) const { return *levels_[static_cast<std::size_t>(n)]; }
  const FieldLevel& finest() const { return *levels_.front(); }
  /// By ghosted node of the finest level: what couples the axes y and z, z and x, x and y (FieldLevel). The preconditioner knows
  /// nothing of it.
  std::array<std::vector<double>, 3>& cross() { return levels_.front()->cross; }
  int n_levels() const { return static_cast<int>(levels_.size()); }
  bool singular() const { return singular_; }
  const LevelShape& coarsest() const { return levels_.back()->shape(); }

  /// Relative permeability of the edge from each node to the next along an axis, by ghosted node of the finest level; to be filled at
  /// owned and ghost nodes before `prepare`. Edges that leave the box are not read, those beyond the ghosts need not be there.
  std::span<const double> edges(int axis) const { return work_.front().edges[static_cast<std::size_t>(axis)]; }
  std::span<double> edges(int axis) { return work_.front().edges[static_cast<std::size_t>(axis)]; }
  /// The operators of all levels from the finest one's edges, which have changed between nodes of `changed` only since the last time.
  /// Collective over the ranks with nodes.
  void prepare(const NodeBox& changed);
  void prepare() { prepare(finest().ghosted()); }

  /// `right`, `solution`: by owned node of the finest level; the solution holds the first guess. Until the largest residual is
  /// `tolerance` times the largest of `right`. Collective over the ranks with nodes.
  PotentialReport solve(std::span<const double> right, double tolerance, int max_iterations, std::span<double> solution);

  std::size_t memory() const;

 private:
  struct Work {
    std::array<std::vector<double>, 3> edges;            // ghosted
    std::vector<float> right, solution, residual, step;  // owned
    std::vector<float> ghosted;
  };

  const Comm& comm() const { return finest().grid().comm(); }
  void coarsen(std::size_t level);
  void set_conductances(std::size_t level, const NodeBox& box);
  void smooth(std::size_t level, int degree, double lowest, bool from_zero);
  void cycle(std::size_t level);
  void restrict_residual(std::size_t level);
  void prolong(std::size_t level);
  void centre(std::span<double> values) const;

  bool singular_;
  std::vector<std::unique_ptr<FieldLevel>> levels_;
  std::vector<Work> work_;
  std::vector<double> residual_, direction_, product_, corrected_;  // of the finest level's owned nodes
  std::vector<double> direction_around_;                            // and of its ghosted ones
};

}  // namespace bulkley
