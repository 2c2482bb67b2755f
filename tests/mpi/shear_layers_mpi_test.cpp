// ranks: 1
// How far the stress falls from a floor to the particles over it. What a fluid makes of that is in layer_return_test.cpp, what becomes of
// layers that stop, in the verification cases of arrest.

#include "integrator/shear_layers.hpp"

#include <gtest/gtest.h>

#include "integrator/floor_pressure.hpp"
#include "support/solver_run.hpp"

namespace bulkley::shear_layers_mpi_test {
namespace {

constexpr LocalIndex block_size = 16;

// A solid, a fluid with a yield stress of 2000 kg/m^3, one without.
Physics physics_of_three() {
  Physics physics = empty_scene({}, {8, 8, 8}, {false, false, false}).physics;
  physics.materials = {{"solid", NeoHookean{{3000.0, 1e5, 3e4}}},
                       {"paste", HerschelBulkley{{2000.0, 1e5, 3e4, 400.0, 50.0, 0.4}}},
                       {"syrup", HerschelBulkley{{2000.0, 1e5, 3e4, 0.0, 50.0, 0.4}}}};
  physics.gravity = {6.0, 0.0, -8.0};
  for (Face& face : physics.faces) face.kind = FaceKind::sticky;
  return physics;
}

// A place along an axis, and what is there.
struct Place {
  int axis;
  double coordinate;  // m
  std::uint8_t material;
  double depth;  // m, of what lies over it and makes its pressure
  double fall;   // expected
};

ParticleSet particles_at(const std::vector<Place>& places, const Physics& physics) {
  ParticleSet particles;
  particles.resize(static_cast<LocalIndex>(places.size()));
  for (std::size_t p = 0; p < places.size(); ++p) {
    for (int a = 0; a < 3; ++a) particles.real(Field::position, a)[p] = 0.5 * (physics.grid.lower[a] + physics.grid.upper()[a]);
    particles.real(Field::position, places[p].axis)[p] = places[p].coordinate;
    particles.material()[p] = places[p].material;
    const double weight = places[p].depth * std::abs(physics.gravity[places[p].axis]);
    double J = 1.0;  // the pressure of a depth of fluid that is as dense as here: 0.5 kappa (1/J - J) = 2000 / J g depth
    for (int k = 0; k < 100; ++k) J = 1.0 - (2000.0 / J) * weight / (0.5e5 * (1.0 + 1.0 / J));
    particles.real(Field::volume_ratio)[p] = J;
  }
  return particles;
}

std::vector<double> falls_of(const Physics& physics, ParticleSet& particles, std::size_t material) {
  FloorPressure pressure(physics, block_size);
  pressure.find(1e-3, particles, {0, block_size});
  ShearLayers layers(physics, block_size);
  layers.find(particles, {0, block_size}, pressure.of_block());
  const double* const falls = layers.of_material(material);
  return falls ? std::vector<double>(falls, falls + particles.size()) : std::vector<double>{};
}

TEST(ShearLayers, StressFallsAsPressureDoes) {
  Physics physics = physics_of_three();
  const GridGeometry& grid = physics.grid;
  const double dx = grid.cell_size, z = grid.lower[2];
  const std::vector<Place> places = {
      {2, z + 0.5 * dx, 1, 4.5 * dx, 0.1},
      {2, z + 1.4 * dx, 1, 5.6 * dx, 0.2},
      {2, z + 0.5 * dx, 1, 0.1 * dx, 0.5},               // no more than the layer
      {2, z + 0.5 * dx, 1, 0.0, 0.0},                    // nothing lies on it
      {2, z + 1.6 * dx, 1, 4.5 * dx, 0.0},               // too far
      {2, z + 0.5 * dx, 0, 4.5 * dx, 0.0},               // a solid
      {2, z + 0.5 * dx, 2, 4.5 * dx, 0.0},               // no yield stress
      {2, grid.upper()[2] - 0.5 * dx, 1, 4.5 * dx, 0.0}, // a ceiling
      {0, grid.upper()[0] - 0.5 * dx, 1, 4.5 * dx, 0.0}, // too steep
  };
  ParticleSet particles = particles_at(places, physics);
  const std::vector<double> falls = falls_of(physics, particles, 1);
  ASSERT_EQ(falls.size(), places.size());
  for (std::size_t p = 0; p < places.size(); ++p) EXPECT_NEAR(falls[p], places[p].fall, 1e-12) << p;
  EXPECT_TRUE(falls_of(physics, particles, 0).empty());
  EXPECT_TRUE(falls_of(physics, particles, 2).empty());
  physics.transfer.order = SplineOrder::cubic;
  EXPECT_NEAR(falls_of(physics, particles, 1)[4], 1.6 / 6.1, 1e-12) << "cubic weights reach farther";
  physics.transfer.thin_layers = false;
  EXPECT_TRUE(falls_of(physics, particles, 1).empty());
}

TEST(ShearLayers, AreOnStickyFloors) {
  Physics physics = physics_of_three();
  ParticleSet particles = particles_at({{2, physics.grid.lower[2] + 0.5 * physics.grid.cell_size, 1, 0.1, 0.0}}, physics);
  EXPECT_FALSE(falls_of(physics, particles, 1).empty());
  for (const FaceKind kind : {FaceKind::slip, FaceKind::separating, FaceKind::outflow}) {
    physics.faces[4].kind = kind;
    EXPECT_TRUE(falls_of(physics, particles, 1).empty());
  }
  physics.faces[4].kind = FaceKind::sticky;
  physics.gravity.setZero();
  EXPECT_TRUE(falls_of(physics, particles, 1).empty());
}

// An upper face is a floor where gravity says so.
TEST(ShearLayers, AreOnFloorsOverhead) {
  Physics physics = physics_of_three();
  physics.gravity = {0.0, 0.0, 9.81};
  const double dx = physics.grid.cell_size;
  ParticleSet particles = particles_at({{2, physics.grid.upper()[2] - 0.5 * dx, 1, 4.5 * dx, 0.0}}, physics);
  EXPECT_NEAR(falls_of(physics, particles, 1)[0], 0.1, 1e-12);
}

}  // namespace
}  // namespace bulkley::shear_layers_mpi_test
