// ranks: 1
// Which materials' particles learn how crowded they are, and what masses are compared with. That J follows, and by how much, is in
// stress_update_test.cpp; what nodes near walls hold, in node_volume_test.cpp.

#include "integrator/crowding.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "support/solver_run.hpp"

namespace bulkley::crowding_mpi_test {
namespace {

constexpr LocalIndex block_size = 16;

// A solid of 3000 kg/m^3 and two fluids of 1000 and 2000.
Physics physics_of_three() {
  Physics physics = empty_scene({}, {8, 8, 8}, {false, false, false}).physics;
  physics.materials = {{"solid", NeoHookean{{3000.0, 1e5, 3e4}}},
                       {"light", HerschelBulkley{{1000.0, 1e5, 3e4, 400.0, 50.0, 0.4}}},
                       {"heavy", HerschelBulkley{{2000.0, 1e5, 3e4, 400.0, 50.0, 0.4}}}};
  return physics;
}

TEST(Crowding, IsForFluidsThatKeepTheVolumeOfCells) {
  Physics physics = physics_of_three();
  const auto takes_part = [&] {
    Crowding crowding(physics, block_size);
    std::vector<bool> result;
    for (std::size_t m = 0; m < 3; ++m) {
      result.push_back(crowding.of_material(m) != nullptr);
      EXPECT_TRUE(!result.back() || crowding.of_material(m) == crowding.of_block());
    }
    EXPECT_EQ(crowding.of_block() != nullptr, result[0] || result[1] || result[2]);
    return result;
  };
  EXPECT_EQ(takes_part(), std::vector({false, false, false})) << "volumes by particles";
  physics.shares_dilation = {1, 1, 0};
  EXPECT_EQ(takes_part(), std::vector({false, true, false})) << "solids keep theirs, whatever they share";
  physics.shares_dilation.clear();
  for (const NamedMaterial& named : physics.materials) physics.volumetric_laws.push_back(volumetric_law(named.material));
  EXPECT_EQ(takes_part(), std::vector({false, true, true})) << "with an implicit pressure";
}

TEST(Crowding, MassesAreComparedWithThoseOfTheDensestMaterial) {
  Physics physics = physics_of_three();
  const double dx = physics.grid.cell_size, full = 3000.0 * dx * dx * dx;
  const std::vector<Node> before = {{{1.0, 2.0, 3.0, full}}, {{4.0, 5.0, 6.0, 0.5 * full}}, {{7.0, 8.0, 9.0, full}}};
  std::vector<Node> nodes = before;
  const std::vector<LocalIndex> active = {0, 1};
  Crowding(physics, block_size).find_fullness(active, nodes.data());
  EXPECT_EQ(std::memcmp(nodes.data(), before.data(), sizeof(Node) * 3), 0) << "no material takes part";
  physics.shares_dilation = {0, 1, 1};
  Crowding(physics, block_size).find_fullness(active, nodes.data());
  EXPECT_DOUBLE_EQ(nodes[0].c[3], 1.0);
  EXPECT_DOUBLE_EQ(nodes[1].c[3], 0.5);
  EXPECT_EQ(nodes[2].c[3], full) << "not active";
  for (std::size_t n = 0; n < 3; ++n)
    for (int a = 0; a < 3; ++a) EXPECT_EQ(nodes[n].c[a], before[n].c[a]);
}

TEST(Crowding, WhatInflowsCarryIsSpared) {
  Physics physics = physics_of_three();
  physics.shares_dilation = {0, 1, 0};
  Crowding crowding(physics, block_size);
  std::vector<char> carried(40, 0);
  carried[17] = carried[20] = carried[33] = 1;
  std::fill_n(crowding.of_block(), block_size, 2.0);
  crowding.spare(nullptr, {16, 32}, 40);
  EXPECT_EQ(crowding.of_block()[1], 2.0);
  crowding.spare(carried.data(), {16, 32}, 40);
  for (int p = 0; p < block_size; ++p) EXPECT_EQ(crowding.of_block()[p], p == 1 || p == 4 ? 0.0 : 2.0) << p;
  std::fill_n(crowding.of_block(), block_size, 2.0);
  crowding.spare(carried.data(), {32, 48}, 34);
  EXPECT_EQ(crowding.of_block()[1], 0.0);
  EXPECT_EQ(crowding.of_block()[2], 2.0);
}

}  // namespace
}  // namespace bulkley::crowding_mpi_test
