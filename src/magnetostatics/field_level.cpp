#include "magnetostatics/field_level.hpp"

#include <algorithm>

namespace bulkley {

NodeBox common(const NodeBox& a, const NodeBox& b) {
  NodeBox both;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    both.first[axis] = std::max(a.first[axis], b.first[axis]);
    const int end = std::min(a.first[axis] + a.count[axis], b.first[axis] + b.count[axis]);
    both.count[axis] = std::max(0, end - both.first[axis]);
  }
  return both;
}

LevelShape shape_of(const FieldLayout& layout) {
  LevelShape shape;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    shape.n_nodes[a] = layout.n_nodes(axis);
    shape.wraps[a] = layout.wraps_along(axis);
    shape.origin[axis] = layout.geometry.node_coordinate(axis, -layout.below[a]);
  }
  shape.spacing = Vec3::Constant(layout.geometry.cell_size);
  return shape;
}

FieldLayout coarse_layout(const LevelShape& shape) {
  FieldLayout layout;
  layout.geometry.periodic = shape.wraps;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    layout.geometry.n_cells[a] = shape.n_nodes[a];
    layout.above[a] = shape.n_nodes[a] - layout.geometry.n_nodes(axis);
  }
  return layout;
}

namespace {

FieldLayout with_ghosts(FieldLayout layout) {
  layout.stencil_width = 1;
  layout.stencil = FieldLayout::Stencil::box;
  layout.margins = true;
  return layout;
}

}  // namespace

FieldLevel::FieldLevel(const Comm& comm, const LevelShape& shape, const FieldLayout& layout, const FieldBoxes& boxes)
    : shape_(shape), grid_(comm, with_ghosts(layout), boxes) {
  if (!grid_.has_nodes()) return;
  owned_ = {grid_.first(), grid_.count()};
  for (std::size_t a = 0; a < 3; ++a) owned_.first[a] += layout.below[a];
  for (std::size_t a = 0; a < 3; ++a) {
    ghosted_.first[a] = owned_.first[a] - 1;
    ghosted_.count[a] = owned_.count[a] + 2;
  }
  BULKLEY_PETSC(DMDAGetScatter(grid_.dm(), &to_ghosted_, nullptr));
  for (auto& values : conductance) values.assign(ghosted_.size(), 0.0);
  leak.assign(owned_.size(), 0.0);
  for (auto& values : single_.conductance) values.assign(ghosted_.size(), 0.0f);
  single_.leak.assign(owned_.size(), 0.0f);
  single_.inverse_diagonal.assign(owned_.size(), 0.0f);
  scratch_.assign(owned_.size(), 0.0);
}

namespace {

template <class Real>
void spread_values(PetscSF to_ghosted, MPI_Datatype type, std::span<const Real> owned, std::span<Real> ghosted) {
  BULKLEY_PETSC(PetscSFBcastBegin(to_ghosted, type, owned.data(), ghosted.data(), MPI_REPLACE));
  BULKLEY_PETSC(PetscSFBcastEnd(to_ghosted, type, owned.data(), ghosted.data(), MPI_REPLACE));
}

// out = leak x + sum of conductance (x - that of the neighbour).
template <class Real>
void multiply_by(const NodeBox& owned, const NodeBox& ghosted, const std::array<std::vector<Real>, 3>& conductance,
                 const std::vector<Real>& leak, std::span<const Real> x, std::span<Real> y) {
  const std::ptrdiff_t sx = ghosted.stride(0), sy = ghosted.stride(1);
  const int n = owned.count[2];
  for_rows(owned, [&](int i, int j) {
    const std::ptrdiff_t at = ghosted.index(i, j, owned.first[2]), from = owned.index(i, j, owned.first[2]);
    const Real* const v = x.data() + at;
    const Real* const cx = conductance[0].data() + at;
    const Real* const cy = conductance[1].data() + at;
    const Real* const cz = conductance[2].data() + at;
    const Real* const out = leak.data() + from;
    Real* const to = y.data() + from;
    for (int k = 0; k < n; ++k) {
      const Real here = v[k];
      to[k] = out[k] * here + (cx[k] * (here - v[k + sx]) + cx[k - sx] * (here - v[k - sx])) +
              (cy[k] * (here - v[k + sy]) + cy[k - sy] * (here - v[k - sy])) +
              (cz[k] * (here - v[k + 1]) + cz[k - 1] * (here - v[k - 1]));
    }
  });
}

}  // namespace

void FieldLevel::spread(std::span<const double> owned, std::span<double> ghosted) const {
  spread_values(to_ghosted_, MPI_DOUBLE, owned, ghosted);
}

void FieldLevel::spread(std::span<const float> owned, std::span<float> ghosted) const {
  spread_values(to_ghosted_, MPI_FLOAT, owned, ghosted);
}

void FieldLevel::refresh(std::span<double> ghosted) {
  for_rows(owned_, [&](int i, int j) {
    std::copy_n(ghosted.data() + ghosted_.index(i, j, owned_.first[2]), owned_.count[2],
                scratch_.data() + owned_.index(i, j, owned_.first[2]));
  });
  spread(scratch_, ghosted);
}

void FieldLevel::set_single(const NodeBox& changed) {
  for_rows(changed, [&](int i, int j) {
    const std::ptrdiff_t at = ghosted_.index(i, j, changed.first[2]);
    for (std::size_t a = 0; a < 3; ++a)
      std::copy_n(conductance[a].data() + at, changed.count[2], single_.conductance[a].data() + at);
  });
  // A conductance belongs to the node after it, too.
  NodeBox box = changed;
  for (int& count : box.count) ++count;
  box = common(box, owned_);
  for_rows(box, [&](int i, int j) {
    const std::ptrdiff_t from = owned_.index(i, j, box.first[2]), at = ghosted_.index(i, j, box.first[2]);
    const std::ptrdiff_t sx = ghosted_.stride(0), sy = ghosted_.stride(1);
    const double* const cx = conductance[0].data() + at;
    const double* const cy = conductance[1].data() + at;
    const double* const cz = conductance[2].data() + at;
    const double* const out = leak.data() + from;
    float* const single_leak = single_.leak.data() + from;
    float* const inverse = single_.inverse_diagonal.data() + from;
    for (int k = 0; k < box.count[2]; ++k) {
      const double sum = out[k] + (cx[k] + cx[k - sx]) + (cy[k] + cy[k - sy]) + (cz[k] + cz[k - 1]);
      single_leak[k] = static_cast<float>(out[k]);
      inverse[k] = static_cast<float>(1.0 / sum);
    }
  });
}

void FieldLevel::multiply(std::span<const float> x, std::span<float> y) const {
  multiply_by(owned_, ghosted_, single_.conductance, single_.leak, x, y);
}

void FieldLevel::multiply(std::span<const double> x, std::span<double> y) const {
  multiply_by(owned_, ghosted_, conductance, leak, x, y);
  if (cross[0].empty()) return;
  add_crossed(
      [&](int b, std::ptrdiff_t place) {
        const std::ptrdiff_t next = ghosted_.stride(b);
        return 0.5 * (x[static_cast<std::size_t>(place + next)] - x[static_cast<std::size_t>(place - next)]);
      },
      y);
}

FieldBoxes aligned_boxes(const LevelShape& coarsest, const std::array<int, 3>& factors, const LevelShape& fine,
                         int n_ranks) {
  LevelShape cells = coarsest;
  for (int a = 0; a < 3; ++a) cells.n_nodes[static_cast<std::size_t>(a)] = coarsest.n_cells(a);
  FieldBoxes boxes = field_boxes(with_ghosts(coarse_layout(cells)), n_ranks);
  for (std::size_t a = 0; a < 3; ++a) {
    for (int& start : boxes.starts[a]) start *= factors[a];
    boxes.starts[a].back() = fine.n_nodes[a];
  }
  return boxes;
}

}  // namespace bulkley
