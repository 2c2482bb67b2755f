// ranks: 1 2 3 4 7 8
#include "field/field_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace bulkley::field_grid_mpi_test {
namespace {

GridGeometry geometry_of(const Int3& n_cells, const std::array<bool, 3>& periodic = {false, false, false}) {
  GridGeometry geometry;
  geometry.lower = Vec3(-0.3, 0.2, 1.0);
  geometry.cell_size = 0.1;
  geometry.n_cells = n_cells;
  geometry.periodic = periodic;
  return geometry;
}

std::vector<FieldLayout> layouts() {
  const GridGeometry open = geometry_of({13, 7, 9}), periodic = geometry_of({12, 8, 16}, {true, true, true}),
                     slab = geometry_of({14, 16, 4}, {false, true, true});
  return {node_fields(open),
          node_fields(periodic),
          node_fields(slab),
          {.geometry = open, .n_components = 3, .stencil_width = 2, .stencil = FieldLayout::Stencil::box},
          {.geometry = open, .stencil_width = 1, .below = {3, 0, 1}, .above = {0, 5, 2}},
          {.geometry = slab, .stencil_width = 1, .wraps = false, .below = {0, 2, 0}}};
}

class FieldGridTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
};

TEST_F(FieldGridTest, EveryNodeHasOneOwner) {
  for (const FieldLayout& layout : layouts()) {
    const FieldGrid grid(comm, layout);
    const Int3 n{layout.n_nodes(0), layout.n_nodes(1), layout.n_nodes(2)};
    std::vector<int> n_owners(static_cast<std::size_t>(n[0]) * n[1] * n[2], 0);
    for (LocalIndex k = 0; k < grid.n_owned(); ++k) {
      const Int3 node = grid.node(k);
      const FieldGrid::Location here = grid.locate(node);
      EXPECT_EQ(here.rank, comm.rank());
      EXPECT_EQ(here.index, k);
      const Int3 from_0{node[0] + layout.below[0], node[1] + layout.below[1], node[2] + layout.below[2]};
      ++n_owners.at((static_cast<std::size_t>(from_0[0]) * n[1] + from_0[1]) * n[2] + from_0[2]);
    }
    BULKLEY_MPI(
        MPI_Allreduce(MPI_IN_PLACE, n_owners.data(), static_cast<int>(n_owners.size()), MPI_INT, MPI_SUM, comm.get()));
    EXPECT_EQ(n_owners, std::vector<int>(n_owners.size(), 1));
    EXPECT_EQ(field_boxes(layout, comm.size()).n_nodes(comm.rank()), grid.n_owned());
  }
}

TEST_F(FieldGridTest, LocateAgreesOnAllRanksAndWraps) {
  for (const FieldLayout& layout : layouts()) {
    const FieldGrid grid(comm, layout);
    const auto last = [&](int axis) { return layout.n_nodes(axis) - layout.below[axis]; };
    for (int i = -layout.below[0]; i < last(0); ++i)
      for (int j = -layout.below[1]; j < last(1); ++j)
        for (int k = -layout.below[2]; k < last(2); ++k) {
          const FieldGrid::Location at = grid.locate({i, j, k});
          ASSERT_TRUE(at.rank >= 0 && at.rank < comm.size());
          ASSERT_EQ(min_global(comm, GlobalIndex{at.index}), max_global(comm, GlobalIndex{at.index}));
          Int3 shifted{i, j, k};
          for (int axis = 0; axis < 3; ++axis)
            if (layout.wraps_along(axis)) shifted[axis] += (axis == 1 ? -1 : 1) * layout.n_nodes(axis);
          const FieldGrid::Location wrapped = grid.locate(shifted);
          ASSERT_EQ(wrapped.rank, at.rank);
          ASSERT_EQ(wrapped.index, at.index);
        }
  }
}

TEST_F(FieldGridTest, ContainsItsOwnLayersAndWrapsWhereAsked) {
  const GridGeometry slab = geometry_of({14, 16, 4}, {false, true, true});
  const FieldGrid grid(comm, {.geometry = slab, .below = {2, 0, 0}, .above = {1, 0, 0}});
  EXPECT_TRUE(grid.contains({0, 0, 0}));
  EXPECT_TRUE(grid.contains({-2, 0, 0}));
  EXPECT_FALSE(grid.contains({-3, 0, 0}));
  EXPECT_TRUE(grid.contains({slab.n_nodes(0), slab.n_nodes(1) + 2, -3}));
  EXPECT_FALSE(grid.contains({slab.n_nodes(0) + 1, 0, 0}));
  const FieldGrid ends(comm, {.geometry = slab, .wraps = false});
  EXPECT_FALSE(ends.contains({0, slab.n_nodes(1), 0}));
  EXPECT_FALSE(ends.contains({0, 0, -1}));
}

TEST_F(FieldGridTest, VectorsHoldOneNodeAfterTheOther) {
  for (const FieldLayout& layout : layouts()) {
    const FieldGrid grid(comm, layout);
    if (!grid.has_nodes()) continue;
    const VecHandle vector = grid.create_global();
    PetscInt n_local = 0;
    BULKLEY_PETSC(VecGetLocalSize(vector.get(), &n_local));
    EXPECT_EQ(static_cast<std::size_t>(n_local), grid.size());
    PetscReal norm = -1.0;
    BULKLEY_PETSC(VecNorm(vector.get(), NORM_INFINITY, &norm));
    EXPECT_EQ(norm, 0.0);

    PetscScalar**** by_indices = nullptr;
    BULKLEY_PETSC(DMDAVecGetArrayDOF(grid.dm(), vector.get(), &by_indices));
    const int n_components = grid.n_components();
    for (LocalIndex n = 0; n < grid.n_owned(); ++n) {
      const Int3 node = grid.node(n);
      for (int c = 0; c < n_components; ++c)
        by_indices[node[0] + layout.below[0]][node[1] + layout.below[1]][node[2] + layout.below[2]][c] =
            1.0 * n_components * n + c;
    }
    BULKLEY_PETSC(DMDAVecRestoreArrayDOF(grid.dm(), vector.get(), &by_indices));
    const PetscScalar* flat = nullptr;
    BULKLEY_PETSC(VecGetArrayRead(vector.get(), &flat));
    for (PetscInt n = 0; n < n_local; ++n) EXPECT_EQ(flat[n], n);
    BULKLEY_PETSC(VecRestoreArrayRead(vector.get(), &flat));
  }
}

// What a solve on the whole grid needs: one unknown, ghosts from the neighbours, and a stencil that gives zero for what is
// linear.
TEST_F(FieldGridTest, TheLaplacianOfALinearFunctionIsZero) {
  for (const Int3& n_cells : {Int3{13, 7, 9}, Int3{24, 4, 4}}) {
    const FieldGrid grid(comm, {.geometry = geometry_of(n_cells), .stencil_width = 1, .below = {2, 0, 0}});
    GlobalIndex n_checked = 0;
    if (grid.has_nodes()) {
      const VecHandle owned = grid.create_global(), ghosted = grid.create_local();
      PetscScalar*** phi = nullptr;
      BULKLEY_PETSC(DMDAVecGetArray(grid.dm(), owned.get(), &phi));
      for (LocalIndex n = 0; n < grid.n_owned(); ++n) {
        const Int3 node = grid.node(n);
        phi[node[0] + 2][node[1]][node[2]] = 5.0 + 3.0 * node[0] - 2.0 * node[1] + 7.0 * node[2];
      }
      BULKLEY_PETSC(DMDAVecRestoreArray(grid.dm(), owned.get(), &phi));
      BULKLEY_PETSC(DMGlobalToLocal(grid.dm(), owned.get(), INSERT_VALUES, ghosted.get()));
      BULKLEY_PETSC(DMDAVecGetArrayRead(grid.dm(), ghosted.get(), &phi));
      for (LocalIndex n = 0; n < grid.n_owned(); ++n) {
        const Int3 node = grid.node(n);
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis)
          for (const int step : {-1, 1}) {
            Int3 next = node;
            next[axis] += step;
            inside = inside && grid.contains(next);
          }
        if (!inside) continue;
        const int i = node[0] + 2, j = node[1], k = node[2];
        EXPECT_EQ(phi[i - 1][j][k] + phi[i + 1][j][k] + phi[i][j - 1][k] + phi[i][j + 1][k] + phi[i][j][k - 1] +
                      phi[i][j][k + 1] - 6.0 * phi[i][j][k],
                  0.0);
        ++n_checked;
      }
      BULKLEY_PETSC(DMDAVecRestoreArrayRead(grid.dm(), ghosted.get(), &phi));
    }
    const FieldLayout& layout = grid.layout();
    EXPECT_EQ(sum_global(comm, n_checked),
              GlobalIndex{layout.n_nodes(0) - 2} * (layout.n_nodes(1) - 2) * (layout.n_nodes(2) - 2));
  }
}

// Where the axis wraps, the neighbour across the boundary is the node at the other end: the same stencil on a wave of the
// axis' length gives its eigenvalue.
TEST_F(FieldGridTest, TheLaplacianOfAPeriodicWaveIsItsEigenvalue) {
  const GridGeometry geometry = geometry_of({12, 8, 16}, {true, true, true});
  const FieldGrid grid(comm, {.geometry = geometry, .stencil_width = 1});
  if (!grid.has_nodes()) return;
  for (int axis = 0; axis < 3; ++axis) {
    const double angle = 2.0 * std::acos(-1.0) / geometry.n_nodes(axis);
    const VecHandle owned = grid.create_global(), ghosted = grid.create_local();
    PetscScalar*** phi = nullptr;
    BULKLEY_PETSC(DMDAVecGetArray(grid.dm(), owned.get(), &phi));
    for (LocalIndex n = 0; n < grid.n_owned(); ++n) {
      const Int3 node = grid.node(n);
      phi[node[0]][node[1]][node[2]] = std::cos(angle * node[axis] + 0.3);
    }
    BULKLEY_PETSC(DMDAVecRestoreArray(grid.dm(), owned.get(), &phi));
    BULKLEY_PETSC(DMGlobalToLocal(grid.dm(), owned.get(), INSERT_VALUES, ghosted.get()));
    BULKLEY_PETSC(DMDAVecGetArrayRead(grid.dm(), ghosted.get(), &phi));
    for (LocalIndex n = 0; n < grid.n_owned(); ++n) {
      const auto [i, j, k] = grid.node(n);
      EXPECT_NEAR(phi[i - 1][j][k] + phi[i + 1][j][k] + phi[i][j - 1][k] + phi[i][j + 1][k] + phi[i][j][k - 1] +
                      phi[i][j][k + 1] - 6.0 * phi[i][j][k],
                  (2.0 * std::cos(angle) - 2.0) * phi[i][j][k], 1e-14);
    }
    BULKLEY_PETSC(DMDAVecRestoreArrayRead(grid.dm(), ghosted.get(), &phi));
  }
}

// --- the division
// ------------------------------------------------------------------------------------------------------------

TEST(FieldBoxes, AreEven) {
  const FieldLayout cube{.geometry = geometry_of({60, 60, 60})};
  const FieldBoxes eight = field_boxes(cube, 8);
  EXPECT_EQ(eight.n_boxes, (Int3{2, 2, 2}));
  for (int rank = 0; rank < 8; ++rank) EXPECT_EQ(eight.n_nodes(rank), 32 * 32 * 32);
  const FieldBoxes long_way = field_boxes({.geometry = geometry_of({252, 4, 4})}, 4);
  EXPECT_EQ(long_way.n_boxes, (Int3{4, 1, 1}));
}

// More ranks than nodes along every axis, primes, and stencils as wide as the boxes: the ranks beyond have none, and nothing
// is refused.
TEST(FieldBoxes, SurplusRanksHaveNoNodes) {
  const FieldLayout small{.geometry = geometry_of({4, 4, 4}, {true, true, true})};
  for (int n_ranks = 1; n_ranks <= 200; ++n_ranks) {
    const FieldBoxes boxes = field_boxes(small, n_ranks);
    GlobalIndex total = 0;
    for (int rank = 0; rank < n_ranks; ++rank) total += boxes.n_nodes(rank);
    EXPECT_EQ(total, 64) << n_ranks;
    EXPECT_EQ(boxes.n_nodes(n_ranks), 0);
  }
  EXPECT_EQ(field_boxes(small, 5).n_ranks(), 4);
  EXPECT_EQ(field_boxes(small, 200).n_ranks(), 64);
  EXPECT_EQ(field_boxes({.geometry = geometry_of({36, 36, 36})}, 67).n_ranks(), 66);
  const FieldLayout wide{.geometry = geometry_of({9, 4, 4}, {false, true, true}), .stencil_width = 4};
  EXPECT_EQ(field_boxes(wide, 8).n_boxes, (Int3{3, 1, 1})) << "13 nodes make three boxes of four";
}

TEST_F(FieldGridTest, WorksWhereSomeRanksHaveNoNodes) {
  const FieldLayout layout{.geometry = geometry_of({9, 4, 4}, {false, true, true}), .n_components = 2, .stencil_width = 4};
  const FieldGrid grid(comm, layout);
  EXPECT_EQ(grid.has_nodes(), comm.rank() < 3);
  EXPECT_EQ(sum_global(comm, GlobalIndex{grid.n_owned()}), 13 * 4 * 4);
  if (!grid.has_nodes()) return;
  EXPECT_EQ(grid.comm().size(), std::min(comm.size(), 3));
  const VecHandle vector = grid.create_global();
  PetscInt size = 0;
  BULKLEY_PETSC(VecGetSize(vector.get(), &size));
  EXPECT_EQ(size, 2 * 13 * 4 * 4);
}

// --- refusals
// ----------------------------------------------------------------------------------------------------------------

std::string refusal(const Comm& comm, const FieldLayout& layout) {
  try {
    const FieldGrid grid(comm, layout);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST_F(FieldGridTest, RefusesMoreNodesThanPetscCanNumber) {
  const int n = sizeof(PetscInt) > 4 ? 2000000 : 1000;
  EXPECT_NE(
      refusal(comm, node_fields(geometry_of({n, n, n}))).find("nodes, more than this PETSc can number (4 unknowns each"),
      std::string::npos);
  // One unknown a node leaves room for four times as many nodes.
  EXPECT_EQ(field_fault({.geometry = geometry_of({n, n, n})}), "");
}

TEST_F(FieldGridTest, RefusesAStencilThatReachesAroundAnAxis) {
  EXPECT_NE(refusal(comm, {.geometry = geometry_of({8, 8, 4}, {true, true, true}), .stencil_width = 5})
                .find("the grid has 8 x 8 x 4 nodes, fewer along an axis than the 5"),
            std::string::npos);
}

}  // namespace
}  // namespace bulkley::field_grid_mpi_test
