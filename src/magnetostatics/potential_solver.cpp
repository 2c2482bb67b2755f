#include "magnetostatics/potential_solver.hpp"

#include <algorithm>
#include <cmath>

#include "parallel/reproducible_sum.hpp"

namespace bulkley {

namespace {

constexpr double highest = 2.0;  // of the spectrum of D^-1 A
constexpr double lowest_smoothed = 0.4;
constexpr double lowest_of_coarsest = 0.05;
constexpr int smoothing_degree = 2;
constexpr int coarsest_degree = 16;

bool coarsens(const LevelShape& fine, int axis) {
  const int n = fine.n_cells(axis);
  return n % 2 == 0 && n > (fine.wraps[static_cast<std::size_t>(axis)] ? 2 : fewest_coarse_cells);
}

LevelShape coarser(const LevelShape& fine) {
  LevelShape coarse = fine;
  for (int axis = 0; axis < 3; ++axis) {
    if (!coarsens(fine, axis)) continue;
    const auto a = static_cast<std::size_t>(axis);
    coarse.n_nodes[a] = fine.n_cells(axis) / 2 + (fine.wraps[a] ? 0 : 1);
    coarse.spacing[axis] = 2.0 * fine.spacing[axis];
  }
  return coarse;
}

// Fine nodes from coarse ones along the axes: 2 where coarsened, else 1.
std::array<int, 3> ratios(const LevelShape& fine, const LevelShape& coarse) {
  std::array<int, 3> ratio;
  for (int axis = 0; axis < 3; ++axis) ratio[static_cast<std::size_t>(axis)] = fine.n_cells(axis) / coarse.n_cells(axis);
  return ratio;
}

struct Weighted {
  int index;
  double weight;
};

// A few nodes along an axis with their weights.
class Stencil {
 public:
  void add(int index, double weight) { entries_[static_cast<std::size_t>(n_++)] = {index, weight}; }
  const Weighted* begin() const { return entries_.data(); }
  const Weighted* end() const { return entries_.data() + n_; }

 private:
  std::array<Weighted, 3> entries_;
  int n_ = 0;
};

// The coarse nodes that a fine node takes its value from.
Stencil sources(int fine, int ratio) {
  Stencil stencil;
  if (ratio == 1) {
    stencil.add(fine, 1.0);
  } else if (fine % 2 == 0) {
    stencil.add(fine / 2, 1.0);
  } else {
    stencil.add((fine - 1) / 2, 0.5);
    stencil.add((fine + 1) / 2, 0.5);
  }
  return stencil;
}

// The fine nodes that take from a coarse one: those of `sources`, transposed.
Stencil targets(int coarse, int ratio) {
  Stencil stencil;
  if (ratio == 1) {
    stencil.add(coarse, 1.0);
    return stencil;
  }
  stencil.add(2 * coarse - 1, 0.5);
  stencil.add(2 * coarse, 1.0);
  stencil.add(2 * coarse + 1, 0.5);
  return stencil;
}

// A weighted sum of rows along z of a box.
class Row {
 public:
  explicit Row(const NodeBox& box) : box_(box), sums_(static_cast<std::size_t>(box.count[2])) {}

  void combine(const std::vector<float>& values, const Stencil& along_x, const Stencil& along_y) {
    std::fill(sums_.begin(), sums_.end(), 0.0f);
    for (const Weighted& u : along_x)
      for (const Weighted& v : along_y) {
        const auto weight = static_cast<float>(u.weight * v.weight);
        const float* const from = values.data() + box_.index(u.index, v.index, box_.first[2]);
        for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] += weight * from[k];
      }
  }
  float operator[](int k) const { return sums_[static_cast<std::size_t>(k - box_.first[2])]; }

 private:
  const NodeBox& box_;
  std::vector<float> sums_;
};

// The fine nodes across an edge whose volumes the coarse node's covers, by their shares.
Stencil across(const LevelShape& coarse, int axis, int index, int ratio) {
  Stencil stencil;
  if (ratio == 1) {
    stencil.add(index, 1.0);
    return stencil;
  }
  const auto a = static_cast<std::size_t>(axis);
  const bool first = !coarse.wraps[a] && index == 0, last = !coarse.wraps[a] && index == coarse.n_nodes[a] - 1;
  if (!first) stencil.add(2 * index - 1, last ? 0.5 : 0.25);
  stencil.add(2 * index, 0.5);
  if (!last) stencil.add(2 * index + 1, first ? 0.5 : 0.25);
  return stencil;
}

double largest_of(const Comm& comm, std::span<const double> values) {
  double largest = 0.0;
  for (const double value : values) largest = std::abs(value) <= largest ? largest : std::abs(value);  // a NaN counts
  return max_global(comm, std::isfinite(largest) ? largest : INFINITY);
}

}  // namespace

std::vector<LevelShape> level_shapes(const FieldLayout& finest) {
  std::vector<LevelShape> shapes{shape_of(finest)};
  while (true) {
    const LevelShape next = coarser(shapes.back());
    if (next.n_nodes == shapes.back().n_nodes) return shapes;
    shapes.push_back(next);
  }
}

PotentialSolver::PotentialSolver(const Comm& comm, const FieldLayout& finest, const Leaks& leaks, bool singular)
    : singular_(singular) {
  const std::vector<LevelShape> shapes = level_shapes(finest);
  for (const LevelShape& shape : shapes) {
    const FieldBoxes boxes = aligned_boxes(shapes.back(), ratios(shape, shapes.back()), shape, comm.size());
    levels_.push_back(std::make_unique<FieldLevel>(comm, shape, levels_.empty() ? finest : coarse_layout(shape), boxes));
    FieldLevel& level = *levels_.back();
    Work& work = work_.emplace_back();
    if (!level.grid().has_nodes()) continue;
    leaks(level);
    for (auto& values : work.edges) values.assign(level.ghosted().size(), 0.0);
    for (auto* values : {&work.right, &work.solution, &work.residual, &work.step})
      values->assign(level.owned().size(), 0.0f);
    work.ghosted.assign(level.ghosted().size(), 0.0f);
  }
}

void PotentialSolver::prepare(const NodeBox& changed) {
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    if (level > 0) {
      coarsen(level);
      for (auto& edges : work_[level].edges) levels_[level]->refresh(edges);
    }
    set_conductances(level, level == 0 ? changed : levels_[level]->ghosted());
  }
}

// Edges of a level from those of the finer one: in series along themselves, side by side across.
void PotentialSolver::coarsen(std::size_t level) {
  const LevelShape& coarse = levels_[level]->shape();
  const NodeBox &owned = levels_[level]->owned(), &to = levels_[level]->ghosted(), &from = levels_[level - 1]->ghosted();
  const std::array<int, 3> ratio = ratios(levels_[level - 1]->shape(), coarse);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    const double* const fine = work_[level - 1].edges[a].data();
    const std::ptrdiff_t next = from.stride(axis);
    Int3 n;
    for_rows(owned, [&](int i, int j) {
      n[0] = i, n[1] = j;
      for (n[2] = owned.first[2]; n[2] < owned.first[2] + owned.count[2]; ++n[2]) {
        if (!coarse.wraps[a] && n[a] == coarse.n_nodes[a] - 1) continue;
        Int3 at;
        at[a] = ratio[a] * n[a];
        double sum = 0.0;
        for (const Weighted& u : across(coarse, b, n[static_cast<std::size_t>(b)], ratio[static_cast<std::size_t>(b)]))
          for (const Weighted& v : across(coarse, c, n[static_cast<std::size_t>(c)], ratio[static_cast<std::size_t>(c)])) {
            at[static_cast<std::size_t>(b)] = u.index;
            at[static_cast<std::size_t>(c)] = v.index;
            const double* const edge = fine + from.index(at);
            const double along = ratio[a] == 1 ? edge[0] : 2.0 * edge[0] * edge[next] / (edge[0] + edge[next]);
            sum += u.weight * v.weight * along;
          }
        work_[level].edges[a][static_cast<std::size_t>(to.index(n))] = sum;
      }
    });
  }
}

// Permeability times area over length, in cells of the finest level; of edges that leave the box, nothing.
void PotentialSolver::set_conductances(std::size_t level, const NodeBox& box) {
  FieldLevel& grid = *levels_[level];
  const LevelShape& shape = grid.shape();
  const double unit = levels_.front()->shape().spacing[0];
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double ratio = shape.spacing[(axis + 1) % 3] * shape.spacing[(axis + 2) % 3] / (shape.spacing[axis] * unit);
    // What an index along each axis contributes to the area: along the edge, whether there is one.
    const auto factor = [&](int b, int index) {
      const auto c = static_cast<std::size_t>(b);
      if (b != axis) return shape.share(b, index);
      return shape.wraps[c] || (index >= 0 && index < shape.n_nodes[c] - 1) ? 1.0 : 0.0;
    };
    std::vector<double> along_z;
    for (int k = 0; k < box.count[2]; ++k) along_z.push_back(factor(2, box.first[2] + k));
    for_rows(box, [&](int i, int j) {
      const std::ptrdiff_t at = grid.ghosted().index(i, j, box.first[2]);
      const double row = ratio * factor(0, i) * factor(1, j);
      const double* const edges = work_[level].edges[a].data() + at;
      double* const to = grid.conductance[a].data() + at;
      for (std::size_t k = 0; k < along_z.size(); ++k) to[k] = row * along_z[k] * edges[k];
    });
  }
  grid.set_single(box);
}

// `degree` steps of the Chebyshev iteration with D^-1 A on [lowest, highest].
void PotentialSolver::smooth(std::size_t level, int degree, double lowest, bool from_zero) {
  const FieldLevel& grid = *levels_[level];
  const std::vector<float>& inverse_diagonal = grid.single().inverse_diagonal;
  Work& work = work_[level];
  const double middle = 0.5 * (highest + lowest), half = 0.5 * (highest - lowest), sigma = middle / half;
  double rho = 1.0 / sigma;
  for (int n = 0; n < degree; ++n) {
    const bool zero = from_zero && n == 0;
    if (!zero) {
      grid.spread(work.solution, work.ghosted);
      grid.multiply(work.ghosted, work.residual);
    }
    const double next = 1.0 / (2.0 * sigma - rho);
    const auto keep = static_cast<float>(n == 0 ? 0.0 : next * rho);
    const auto gain = static_cast<float>(n == 0 ? 1.0 / middle : 2.0 * next / half);
    if (n > 0) rho = next;
    for (std::size_t i = 0; i < work.solution.size(); ++i) {
      const float lack = zero ? work.right[i] : work.right[i] - work.residual[i];
      const float step = keep * work.step[i] + gain * (inverse_diagonal[i] * lack);
      work.step[i] = step;
      work.solution[i] = zero ? step : work.solution[i] + step;
    }
  }
}

// solution = about A^-1 right, from zero.
void PotentialSolver::cycle(std::size_t level) {
  if (level + 1 == levels_.size()) return smooth(level, coarsest_degree, lowest_of_coarsest, true);
  smooth(level, smoothing_degree, lowest_smoothed, true);
  restrict_residual(level);
  cycle(level + 1);
  prolong(level);
  smooth(level, smoothing_degree, lowest_smoothed, false);
}

void PotentialSolver::restrict_residual(std::size_t level) {
  const FieldLevel &fine = *levels_[level], &coarse = *levels_[level + 1];
  Work& work = work_[level];
  fine.spread(work.solution, work.ghosted);
  fine.multiply(work.ghosted, work.residual);
  for (std::size_t i = 0; i < work.residual.size(); ++i) work.residual[i] = work.right[i] - work.residual[i];
  fine.spread(work.residual, work.ghosted);

  const std::array<int, 3> ratio = ratios(fine.shape(), coarse.shape());
  const NodeBox &from = fine.ghosted(), &to = coarse.owned();
  Row row(from);
  std::vector<float>& right = work_[level + 1].right;
  for_rows(to, [&](int i, int j) {
    row.combine(work.ghosted, targets(i, ratio[0]), targets(j, ratio[1]));
    float* const out = right.data() + to.index(i, j, to.first[2]);
    for (int n = 0, k = to.first[2]; n < to.count[2]; ++n, ++k)
      out[n] = ratio[2] == 1 ? row[k] : 0.5f * (row[2 * k - 1] + row[2 * k + 1]) + row[2 * k];
  });
}

void PotentialSolver::prolong(std::size_t level) {
  const FieldLevel &fine = *levels_[level], &coarse = *levels_[level + 1];
  coarse.spread(work_[level + 1].solution, work_[level + 1].ghosted);
  const std::array<int, 3> ratio = ratios(fine.shape(), coarse.shape());
  const NodeBox &from = coarse.ghosted(), &to = fine.owned();
  Row row(from);
  for_rows(to, [&](int i, int j) {
    row.combine(work_[level + 1].ghosted, sources(i, ratio[0]), sources(j, ratio[1]));
    float* const out = work_[level].solution.data() + to.index(i, j, to.first[2]);
    for (int n = 0, k = to.first[2]; n < to.count[2]; ++n, ++k)
      out[n] += ratio[2] == 1 ? row[k] : k % 2 == 0 ? row[k / 2] : 0.5f * (row[k / 2] + row[k / 2 + 1]);
  });
}

// Subtracts the mean over all nodes.
void PotentialSolver::centre(std::span<double> values) const {
  const Int3& n = finest().shape().n_nodes;
  const double mean = reproducible_sum(comm(), values) / (1.0 * n[0] * n[1] * n[2]);
  for (double& value : values) value -= mean;
}

PotentialReport PotentialSolver::solve(std::span<const double> right, double tolerance, int max_iterations,
                                       std::span<double> solution) {
  const FieldLevel& grid = finest();
  const std::size_t n = right.size();
  const double size = largest_of(comm(), right);
  PotentialReport report;
  if (size == 0.0) {
    std::fill(solution.begin(), solution.end(), 0.0);
    return report;
  }
  for (auto* values : {&residual_, &direction_, &product_, &corrected_}) values->resize(n);
  direction_around_.resize(grid.ghosted().size());
  std::vector<double>&residual = residual_, &direction = direction_, &product = product_, &corrected = corrected_;
  std::span<double> ghosted = direction_around_;
  std::fill(direction.begin(), direction.end(), 0.0);
  grid.spread(solution, ghosted);
  grid.multiply(ghosted, residual);
  for (std::size_t i = 0; i < n; ++i) residual[i] = right[i] - residual[i];
  // Single precision holds residuals over the right side's size, whatever the units.
  const auto precondition = [&] {
    Work& work = work_.front();
    for (std::size_t i = 0; i < n; ++i) work.right[i] = static_cast<float>(residual[i] / size);
    cycle(0);
    for (std::size_t i = 0; i < n; ++i) corrected[i] = work.solution[i];
    if (singular_) centre(corrected);
  };
  double power = 0.0;
  while (true) {
    if (singular_) centre(residual);
    report.residual = largest_of(comm(), residual) / size;
    if (report.residual <= tolerance) break;
    if (report.n_iterations == max_iterations || !std::isfinite(report.residual)) {
      report.solved = false;
      break;
    }
    precondition();
    const double next = reproducible_dot(comm(), residual, corrected);
    const double ratio = power == 0.0 ? 0.0 : next / power;
    power = next;
    for (std::size_t i = 0; i < n; ++i) direction[i] = corrected[i] + ratio * direction[i];
    grid.spread(direction, ghosted);
    grid.multiply(ghosted, product);
    const double curvature = reproducible_dot(comm(), direction, product);
    if (!(curvature > 0.0)) {
      report.solved = false;
      break;
    }
    const double length = power / curvature;
    for (std::size_t i = 0; i < n; ++i) {
      solution[i] += length * direction[i];
      residual[i] -= length * product[i];
    }
    ++report.n_iterations;
  }
  if (singular_) centre(solution);
  return report;
}

std::size_t PotentialSolver::memory() const {
  std::size_t n_values = 5 * finest().owned().size();
  for (std::size_t level = 0; level < levels_.size(); ++level)
    n_values += 8 * levels_[level]->ghosted().size() + 5 * levels_[level]->owned().size();
  return n_values * sizeof(double);
}

}  // namespace bulkley
