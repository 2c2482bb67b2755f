#include "field/field_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace bulkley {

namespace {

using Axes = std::array<int, 3>;

// Largest number of boxes along each axis.
Axes most_boxes(const FieldLayout& layout) {
  Axes most{};
  for (int axis = 0; axis < 3; ++axis)
    most[static_cast<std::size_t>(axis)] = layout.n_nodes(axis) / std::max(layout.stencil_width, 1);
  return most;
}

// Nodes of the largest box, then nodes on those of its faces that have a neighbour.
std::tuple<GlobalIndex, GlobalIndex> cost_of(const FieldLayout& layout, const Int3& n_boxes) {
  std::array<GlobalIndex, 3> n{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    n[a] = (layout.n_nodes(axis) + n_boxes[a] - 1) / n_boxes[a];
  }
  GlobalIndex faces = 0;
  for (std::size_t a = 0; a < 3; ++a) faces += std::min(n_boxes[a] - 1, 2) * n[(a + 1) % 3] * n[(a + 2) % 3];
  return {n[0] * n[1] * n[2], faces};
}

// The cheapest of the ways to cut exactly so many boxes; all zero if there is none.
Int3 best_cut(const FieldLayout& layout, int n_boxes) {
  const Axes most = most_boxes(layout);
  Int3 best{0, 0, 0};
  for (int a = 1; a <= std::min(most[0], n_boxes); ++a) {
    if (n_boxes % a != 0) continue;
    for (int b = 1; b <= std::min(most[1], n_boxes / a); ++b) {
      const Int3 cut{a, b, n_boxes / a / b};
      if (n_boxes / a % b != 0 || cut[2] > most[2]) continue;
      if (best[0] == 0 || cost_of(layout, cut) < cost_of(layout, best)) best = cut;
    }
  }
  return best;
}

std::vector<PetscInt> widths(const std::vector<int>& starts) {
  std::vector<PetscInt> result;
  for (std::size_t n = 1; n < starts.size(); ++n) result.push_back(starts[n] - starts[n - 1]);
  return result;
}

}  // namespace

GlobalIndex FieldBoxes::n_nodes(int rank) const {
  if (rank >= n_ranks()) return 0;
  const std::array<int, 3> box{rank / (n_boxes[1] * n_boxes[2]), rank / n_boxes[2] % n_boxes[1], rank % n_boxes[2]};
  GlobalIndex n = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(box[axis]);
    n *= starts[axis][at + 1] - starts[axis][at];
  }
  return n;
}

std::string field_fault(const FieldLayout& layout) {
  const int nx = layout.n_nodes(0), ny = layout.n_nodes(1), nz = layout.n_nodes(2);
  if (1.0 * nx * ny * nz * layout.n_components > static_cast<double>(PETSC_MAX_INT))
    return fmt::format(
        "the grid has {} x {} x {} nodes, more than this PETSc can number ({} unknowns each, {}-bit indices); "
        "use a coarser grid or a PETSc with 64-bit indices",
        nx, ny, nz, layout.n_components, 8 * sizeof(PetscInt));
  const int thinnest = std::min({nx, ny, nz});
  if (thinnest < std::max(layout.stencil_width, 1))
    return fmt::format(
        "the grid has {} x {} x {} nodes, fewer along an axis than the {} that a stencil reaches; use a finer grid", nx, ny,
        nz, layout.stencil_width);
  return {};
}

FieldBoxes field_boxes(const FieldLayout& layout, int n_ranks) {
  FieldBoxes boxes;
  const Axes most = most_boxes(layout);
  int n = static_cast<int>(std::min<GlobalIndex>(n_ranks, GlobalIndex{most[0]} * most[1] * most[2]));
  do boxes.n_boxes = best_cut(layout, n);
  while (boxes.n_boxes[0] == 0 && --n > 0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const GlobalIndex n_nodes = layout.n_nodes(axis), parts = boxes.n_boxes[a];
    for (GlobalIndex part = 0; part <= parts; ++part) boxes.starts[a].push_back(static_cast<int>(n_nodes * part / parts));
  }
  return boxes;
}

namespace {

const FieldLayout& checked(const FieldLayout& layout) {
  for (int axis = 0; axis < 3; ++axis)
    if (layout.wraps_along(axis)) BULKLEY_ASSERT(layout.n_nodes(axis) == layout.geometry.n_nodes(axis));
  if (const std::string fault = field_fault(layout); !fault.empty()) throw UsageError(fault);
  return layout;
}

}  // namespace

FieldGrid::FieldGrid(const Comm& comm, const FieldLayout& layout)
    : FieldGrid(comm, layout, field_boxes(checked(layout), comm.size())) {}

FieldGrid::FieldGrid(const Comm& comm, const FieldLayout& layout, FieldBoxes boxes)
    : all_(comm), layout_(checked(layout)), boxes_(std::move(boxes)) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (int box = 0; box < boxes_.n_boxes[axis]; ++box)
      box_[axis].resize(static_cast<std::size_t>(boxes_.starts[axis][static_cast<std::size_t>(box) + 1]), box);

  if (const bool has_box = comm.rank() < boxes_.n_ranks(); boxes_.n_ranks() < comm.size()) {
    MPI_Comm part = MPI_COMM_NULL;
    BULKLEY_MPI(MPI_Comm_split(comm.get(), has_box ? 0 : MPI_UNDEFINED, comm.rank(), &part));
    if (!has_box) return;
    part_.emplace(part);
    BULKLEY_MPI(MPI_Comm_free(&part));
  }

  std::array<DMBoundaryType, 3> ends;
  for (int axis = 0; axis < 3; ++axis)
    ends[static_cast<std::size_t>(axis)] = layout.wraps_along(axis) ? DM_BOUNDARY_PERIODIC
                                           : layout.margins         ? DM_BOUNDARY_GHOSTED
                                                                    : DM_BOUNDARY_NONE;
  const std::vector<PetscInt> nx = widths(boxes_.starts[0]), ny = widths(boxes_.starts[1]), nz = widths(boxes_.starts[2]);
  const DMDAStencilType stencil = layout.stencil == FieldLayout::Stencil::box ? DMDA_STENCIL_BOX : DMDA_STENCIL_STAR;
  BULKLEY_PETSC(DMDACreate3d(this->comm().get(), ends[2], ends[1], ends[0], stencil, layout.n_nodes(2), layout.n_nodes(1),
                             layout.n_nodes(0), boxes_.n_boxes[2], boxes_.n_boxes[1], boxes_.n_boxes[0], layout.n_components,
                             layout.stencil_width, nz.data(), ny.data(), nx.data(), dm_.put()));
  BULKLEY_PETSC(DMSetUp(dm_.get()));
  PetscInt x, y, z, width_x, width_y, width_z;
  BULKLEY_PETSC(DMDAGetCorners(dm_.get(), &z, &y, &x, &width_z, &width_y, &width_x));
  first_ = {static_cast<int>(x) - layout.below[0], static_cast<int>(y) - layout.below[1],
            static_cast<int>(z) - layout.below[2]};
  count_ = {static_cast<int>(width_x), static_cast<int>(width_y), static_cast<int>(width_z)};
}

VecHandle FieldGrid::create_global() const {
  VecHandle vector;
  BULKLEY_PETSC(DMCreateGlobalVector(dm_.get(), vector.put()));
  BULKLEY_PETSC(VecSet(vector.get(), 0.0));
  return vector;
}

VecHandle FieldGrid::create_local() const {
  VecHandle vector;
  BULKLEY_PETSC(DMCreateLocalVector(dm_.get(), vector.put()));
  BULKLEY_PETSC(VecSet(vector.get(), 0.0));
  return vector;
}

bool FieldGrid::contains(const Int3& node) const {
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int index = node[a] + layout_.below[a];
    if (!layout_.wraps_along(axis) && (index < 0 || index >= layout_.n_nodes(axis))) return false;
  }
  return true;
}

FieldGrid::Location FieldGrid::locate(const Int3& node) const {
  BULKLEY_ASSERT(contains(node));
  Int3 box, local, width;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int n = layout_.n_nodes(axis);
    int index = node[a] + layout_.below[a];
    if (layout_.wraps_along(axis)) index = (index % n + n) % n;
    box[a] = box_[a][static_cast<std::size_t>(index)];
    const int start = boxes_.starts[a][static_cast<std::size_t>(box[a])];
    local[a] = index - start;
    width[a] = boxes_.starts[a][static_cast<std::size_t>(box[a]) + 1] - start;
  }
  return {(box[0] * boxes_.n_boxes[1] + box[1]) * boxes_.n_boxes[2] + box[2],
          (local[0] * width[1] + local[1]) * width[2] + local[2]};
}

}  // namespace bulkley
