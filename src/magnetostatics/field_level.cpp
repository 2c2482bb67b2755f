#include "magnetostatics/field_level.hpp"

#include <algorithm>

namespace bulkley {

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
  global_ = grid_.create_global();
  local_ = grid_.create_local();
  for (auto& values : conductance) values.assign(ghosted_.size(), 0.0);
  leak.assign(owned_.size(), 0.0);
  inverse_diagonal.assign(owned_.size(), 0.0);
  scratch_.assign(owned_.size(), 0.0);
}

void FieldLevel::spread(std::span<const double> owned, std::span<double> ghosted) const {
  BULKLEY_PETSC(VecPlaceArray(global_.get(), owned.data()));
  BULKLEY_PETSC(VecPlaceArray(local_.get(), ghosted.data()));
  BULKLEY_PETSC(DMGlobalToLocalBegin(grid_.dm(), global_.get(), INSERT_VALUES, local_.get()));
  BULKLEY_PETSC(DMGlobalToLocalEnd(grid_.dm(), global_.get(), INSERT_VALUES, local_.get()));
  BULKLEY_PETSC(VecResetArray(local_.get()));
  BULKLEY_PETSC(VecResetArray(global_.get()));
}

void FieldLevel::refresh(std::span<double> ghosted) {
  for_rows(owned_, [&](int i, int j) {
    std::copy_n(ghosted.data() + ghosted_.index(i, j, owned_.first[2]), owned_.count[2],
                scratch_.data() + owned_.index(i, j, owned_.first[2]));
  });
  spread(scratch_, ghosted);
}

void FieldLevel::set_diagonal() {
  for_rows(owned_, [&](int i, int j) {
    const std::ptrdiff_t from = owned_.index(i, j, owned_.first[2]), at = ghosted_.index(i, j, owned_.first[2]);
    for (int k = 0; k < owned_.count[2]; ++k) {
      double sum = leak[static_cast<std::size_t>(from + k)];
      for (int a = 0; a < 3; ++a) {
        const double* const c = conductance[static_cast<std::size_t>(a)].data() + at + k;
        sum += c[0] + c[-ghosted_.stride(a)];
      }
      inverse_diagonal[static_cast<std::size_t>(from + k)] = 1.0 / sum;
    }
  });
}

void FieldLevel::multiply(std::span<const double> x, std::span<double> y) const {
  const std::ptrdiff_t sx = ghosted_.stride(0), sy = ghosted_.stride(1);
  const int n = owned_.count[2];
  for_rows(owned_, [&](int i, int j) {
    const std::ptrdiff_t at = ghosted_.index(i, j, owned_.first[2]), from = owned_.index(i, j, owned_.first[2]);
    const double* const v = x.data() + at;
    const double* const cx = conductance[0].data() + at;
    const double* const cy = conductance[1].data() + at;
    const double* const cz = conductance[2].data() + at;
    const double* const out = leak.data() + from;
    double* const to = y.data() + from;
    for (int k = 0; k < n; ++k) {
      const double here = v[k];
      to[k] = out[k] * here + (cx[k] * (here - v[k + sx]) + cx[k - sx] * (here - v[k - sx])) +
              (cy[k] * (here - v[k + sy]) + cy[k - sy] * (here - v[k - sy])) +
              (cz[k] * (here - v[k + 1]) + cz[k - 1] * (here - v[k - 1]));
    }
  });
}

void FieldLevel::multiply_crossed(std::span<const double> x, std::span<double> y) const {
  multiply(x, y);
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
