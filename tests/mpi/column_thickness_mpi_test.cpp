// ranks: 1 2 3 7
#include "integrator/column_thickness.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/solver_run.hpp"

namespace bulkley::column_thickness_mpi_test {
namespace {

const Vec3 down(0.0, 0.0, -9.81);

class ColumnThicknessTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  SolverScene scene = empty_scene({}, {8, 8, 8}, {false, false, false});

  double decile(const Vec3& gravity) const {
    const ParticleSet& all = scene.particles;
    Vec3 lower = all.vector(Field::position, 0), upper = lower;
    for (LocalIndex p = 0; p < all.size(); ++p) {
      lower = lower.cwiseMin(all.vector(Field::position, p));
      upper = upper.cwiseMax(all.vector(Field::position, p));
    }
    const double found = thickness_decile(comm, scene.physics.grid, gravity, share_of(comm, all, {}), lower, upper);
    EXPECT_EQ(std::isnan(found), !comm.is_root() || gravity.isZero());
    return found;
  }
};

// A floor of 8 x 8 columns one cell high, and a tower of 2 x 2 columns on it, six cells high in all.
TEST_F(ColumnThicknessTest, IsThatOfTheThinnestTenth) {
  const Vec3 corner = scene.physics.grid.lower;
  add_block(scene, corner, {16, 16, 2}, 0, Vec3::Zero());
  add_block(scene, corner + Vec3(0.2, 0.2, 0.1), {4, 4, 10}, 0, Vec3::Zero());
  const double thin = decile(down);
  if (comm.is_root()) {
    EXPECT_NEAR(thin, 1.0, 1e-9);
    EXPECT_EQ(thin, std::nearbyint(0x1p40 * thin) * 0x1p-40);
  }
  // Along x every column of the floor is eight cells long, and a tenth of the volume is in the tower's of two.
  const double across = decile(Vec3(3.0, 0.0, -1.0));
  if (comm.is_root()) {
    EXPECT_NEAR(across, 2.0, 1e-9);
  }
}

TEST_F(ColumnThicknessTest, WithoutGravityIsNoNumber) {
  add_block(scene, scene.physics.grid.lower, {4, 4, 4}, 0, Vec3::Zero());
  decile(Vec3::Zero());
}

// What hovers above counts together; half a cell is half a cell.
TEST_F(ColumnThicknessTest, CountsVolume) {
  const Vec3 corner = scene.physics.grid.lower;
  add_block(scene, corner, {16, 16, 1}, 0, Vec3::Zero());
  const double one = decile(down);
  add_block(scene, corner + Vec3(0.0, 0.0, 0.4), {16, 16, 4}, 0, Vec3::Zero());
  const double both = decile(down);
  if (!comm.is_root()) return;
  EXPECT_NEAR(one, 0.5, 1e-9);
  EXPECT_NEAR(both, 2.5, 1e-9);
}

}  // namespace
}  // namespace bulkley::column_thickness_mpi_test
