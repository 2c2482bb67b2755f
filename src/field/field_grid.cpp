#include "field/field_grid.hpp"

#include <fmt/format.h>

#include <numeric>

namespace bulkley {

namespace {

constexpr int n_unknowns = 4;  // per node, see Node

int wrapped(int index, int n_nodes) { return (index % n_nodes + n_nodes) % n_nodes; }

std::vector<PetscInt> petsc_ranges(const std::vector<int>& nodes) { return {nodes.begin(), nodes.end()}; }

}  // namespace

bool Grid::fits(const GridGeometry& geometry) {
  return GlobalIndex{1} * geometry.n_nodes(0) * geometry.n_nodes(1) * geometry.n_nodes(2) <= PETSC_MAX_INT / n_unknowns;
}

void Grid::check_fits(const GridGeometry& geometry) {
  if (!fits(geometry))
    throw UsageError(
        fmt::format("the grid has {} x {} x {} nodes, more than this PETSc can number ({} unknowns each, {}-bit "
                    "indices); use a coarser grid or a PETSc with 64-bit indices",
                    geometry.n_nodes(0), geometry.n_nodes(1), geometry.n_nodes(2), n_unknowns, 8 * sizeof(PetscInt)));
}

Grid::Grid(const Comm& comm, const GridGeometry& geometry, const Boxes& boxes) : geometry_(geometry) {
  check_fits(geometry);
  n_ranks_ = boxes.n_ranks;
  BULKLEY_ASSERT(n_ranks_[0] * n_ranks_[1] * n_ranks_[2] == comm.size());
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<int>& nodes = boxes.nodes[axis];
    BULKLEY_ASSERT(std::accumulate(nodes.begin(), nodes.end(), 0) == geometry.n_nodes(axis));
    starts_[axis].push_back(0);
    for (int process = 0; process < n_ranks_[axis]; ++process) {
      starts_[axis].push_back(starts_[axis].back() + nodes[process]);
      process_[axis].insert(process_[axis].end(), nodes[process], process);
    }
  }

  const std::vector<PetscInt> lx = petsc_ranges(boxes.nodes[0]), ly = petsc_ranges(boxes.nodes[1]),
                              lz = petsc_ranges(boxes.nodes[2]);
  BULKLEY_PETSC(DMDACreate3d(comm.get(), DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_BOX,
                             geometry.n_nodes(2), geometry.n_nodes(1), geometry.n_nodes(0), n_ranks_[2], n_ranks_[1],
                             n_ranks_[0], n_unknowns, 0, lz.data(), ly.data(), lx.data(), dm_.put()));
  BULKLEY_PETSC(DMSetUp(dm_.get()));
  PetscInt x, y, z, nx, ny, nz;
  BULKLEY_PETSC(DMDAGetCorners(dm_.get(), &z, &y, &x, &nz, &ny, &nx));
  first_ = {static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)};
  count_ = {static_cast<int>(nx), static_cast<int>(ny), static_cast<int>(nz)};
}

VecHandle Grid::create_vector() const {
  VecHandle vector;
  BULKLEY_PETSC(DMCreateGlobalVector(dm_.get(), vector.put()));
  BULKLEY_PETSC(VecSet(vector.get(), 0.0));
  return vector;
}

bool Grid::contains(const Int3& node) const {
  for (int axis = 0; axis < 3; ++axis)
    if (!geometry_.periodic[axis] && (node[axis] < 0 || node[axis] >= geometry_.n_nodes(axis))) return false;
  return true;
}

Grid::Location Grid::locate(const Int3& node) const {
  BULKLEY_ASSERT(contains(node));
  Int3 process, local, width;
  for (int axis = 0; axis < 3; ++axis) {
    const int index = geometry_.periodic[axis] ? wrapped(node[axis], geometry_.n_nodes(axis)) : node[axis];
    process[axis] = process_[axis][index];
    local[axis] = index - starts_[axis][process[axis]];
    width[axis] = starts_[axis][process[axis] + 1] - starts_[axis][process[axis]];
  }
  return {(process[0] * n_ranks_[1] + process[1]) * n_ranks_[2] + process[2],
          (local[0] * width[1] + local[1]) * width[2] + local[2]};
}

}  // namespace bulkley
