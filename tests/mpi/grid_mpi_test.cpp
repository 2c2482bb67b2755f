// ranks: 1 2 3 4 8
#include "field/field_grid.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace bulkley {
namespace {

std::vector<GridGeometry> geometries() {
  GridGeometry open;
  open.cell_size = 0.1;
  open.n_cells = {13, 7, 9};
  GridGeometry periodic = open;
  periodic.n_cells = {12, 8, 16};
  periodic.periodic = {true, true, true};
  GridGeometry slab = open;  // plane flow: one tile thick
  slab.n_cells = {14, 16, 4};
  slab.periodic = {false, true, true};
  return {open, periodic, slab};
}

// More load towards the upper corner, so that the ranges are uneven.
Partition uneven_partition(const GridGeometry& geometry, int n_ranks) {
  std::vector<GlobalIndex> load(geometry.n_tiles());
  for (TileIndex tile = 0; tile < geometry.n_tiles(); ++tile) load[tile] = tile * tile;
  return make_partition(geometry, {PartitionMethod::ranges}, tile_load(load), n_ranks);
}

class GridTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
};

TEST_F(GridTest, EveryNodeHasOneOwner) {
  for (const GridGeometry& geometry : geometries()) {
    const Partition partition = uneven_partition(geometry, comm.size());
    const Grid grid(comm, geometry, *partition.boxes);
    const Int3 n{geometry.n_nodes(0), geometry.n_nodes(1), geometry.n_nodes(2)};
    std::vector<int> n_owners(static_cast<std::size_t>(n[0]) * n[1] * n[2], 0), claimed(n_owners);
    for (LocalIndex k = 0; k < grid.n_owned(); ++k) {
      const Int3 node = grid.node(k);
      const Grid::Location here = grid.locate(node);
      EXPECT_EQ(here.rank, comm.rank());
      EXPECT_EQ(here.index, k);
      EXPECT_EQ(partition.map.owner(geometry.tile_of_node(node)), comm.rank());
      ++n_owners[(static_cast<std::size_t>(node[0]) * n[1] + node[1]) * n[2] + node[2]];
    }
    BULKLEY_MPI(
        MPI_Allreduce(n_owners.data(), claimed.data(), static_cast<int>(claimed.size()), MPI_INT, MPI_SUM, comm.get()));
    EXPECT_EQ(claimed, std::vector<int>(claimed.size(), 1));
  }
}

TEST_F(GridTest, LocateAgreesOnAllRanksAndWraps) {
  for (const GridGeometry& geometry : geometries()) {
    const Grid grid(comm, geometry, *uneven_partition(geometry, comm.size()).boxes);
    for (int i = 0; i < geometry.n_nodes(0); ++i)
      for (int j = 0; j < geometry.n_nodes(1); ++j)
        for (int k = 0; k < geometry.n_nodes(2); ++k) {
          const Grid::Location at = grid.locate({i, j, k});
          EXPECT_TRUE(at.rank >= 0 && at.rank < comm.size());
          EXPECT_EQ(min_global(comm, GlobalIndex{at.index}), max_global(comm, GlobalIndex{at.index}));
          Int3 shifted{i, j, k};
          for (int axis = 0; axis < 3; ++axis)
            if (geometry.periodic[axis]) shifted[axis] += (axis == 1 ? -1 : 1) * geometry.n_nodes(axis);
          const Grid::Location wrapped = grid.locate(shifted);
          EXPECT_EQ(wrapped.rank, at.rank);
          EXPECT_EQ(wrapped.index, at.index);
        }
  }
}

TEST_F(GridTest, ContainsWrapsPeriodicAxesOnly) {
  const GridGeometry slab = geometries()[2];
  const Grid grid(comm, slab, *uneven_partition(slab, comm.size()).boxes);
  EXPECT_TRUE(grid.contains({0, 0, 0}));
  EXPECT_TRUE(grid.contains({slab.n_nodes(0) - 1, slab.n_nodes(1) + 2, -3}));
  EXPECT_FALSE(grid.contains({slab.n_nodes(0), 0, 0}));
  EXPECT_FALSE(grid.contains({-1, 0, 0}));
}

TEST_F(GridTest, VectorsHoldOneNodeAfterTheOther) {
  for (const GridGeometry& geometry : geometries()) {
    const Grid grid(comm, geometry, *uneven_partition(geometry, comm.size()).boxes);
    const VecHandle vector = grid.create_vector();
    PetscInt n_local = 0;
    BULKLEY_PETSC(VecGetLocalSize(vector.get(), &n_local));
    EXPECT_EQ(n_local, 4 * grid.n_owned());
    PetscReal norm = -1.0;
    BULKLEY_PETSC(VecNorm(vector.get(), NORM_INFINITY, &norm));
    EXPECT_EQ(norm, 0.0);

    PetscScalar**** by_indices = nullptr;
    BULKLEY_PETSC(DMDAVecGetArrayDOF(grid.dm(), vector.get(), &by_indices));
    for (LocalIndex n = 0; n < grid.n_owned(); ++n) {
      const Int3 node = grid.node(n);
      for (int c = 0; c < 4; ++c) by_indices[node[0]][node[1]][node[2]][c] = 4.0 * n + c;
    }
    BULKLEY_PETSC(DMDAVecRestoreArrayDOF(grid.dm(), vector.get(), &by_indices));
    const PetscScalar* flat = nullptr;
    BULKLEY_PETSC(VecGetArrayRead(vector.get(), &flat));
    for (PetscInt n = 0; n < n_local; ++n) EXPECT_EQ(flat[n], n);
    BULKLEY_PETSC(VecRestoreArrayRead(vector.get(), &flat));
  }
}

TEST_F(GridTest, RefusesMoreNodesThanPetscCanNumber) {
  GridGeometry huge;
  huge.cell_size = 1.0;
  huge.n_cells = {1000, 1000, 1000};
  if (sizeof(PetscInt) > 4) huge.n_cells = {2000000, 2000000, 2000000};
  try {
    Grid(comm, huge, Boxes{});
    ADD_FAILURE() << "accepted";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("nodes, more than this PETSc can number"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace bulkley
