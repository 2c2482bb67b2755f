// ranks: 1
// With which pressure fluids lie on floors, and that it does not follow sound. What becomes of voids under it is in crowding_mpi_test.cpp, of
// layers in shear_layers_mpi_test.cpp.

#include "integrator/floor_pressure.hpp"

#include <gtest/gtest.h>

#include "support/solver_run.hpp"

namespace bulkley::floor_pressure_mpi_test {
namespace {

constexpr LocalIndex block_size = 16;
constexpr double bulk_modulus = 1e6, density = 2000.0;

// A solid and a fluid.
Physics physics_of_two() {
  Physics physics = empty_scene({}, {8, 8, 8}, {false, false, false}).physics;
  physics.materials = {{"solid", NeoHookean{{density, bulk_modulus, 3e4}}},
                       {"syrup", HerschelBulkley{{density, bulk_modulus, 3e4, 0.0, 50.0, 0.4}}}};
  physics.shares_dilation = {0, 1};
  physics.gravity = {6.0, 0.0, -8.0};
  return physics;
}

// Material `m` at `cells` from the lower end of the domain.
ParticleSet particle_at(const Vec3& cells, std::uint8_t m, const Physics& physics, OptionalFields fields = {}) {
  ParticleSet particles(fields);
  particles.resize(1);
  particles.set_vector(Field::position, 0, physics.grid.lower + cells * physics.grid.cell_size);
  particles.material()[0] = m;
  particles.real(Field::volume_ratio)[0] = 1.0;
  return particles;
}

double pressure_of(const Physics& physics, ParticleSet& particles) {
  FloorPressure pressure(physics, block_size);
  pressure.find(1e-3, particles, {0, block_size});
  return pressure.of_block() ? pressure.of_block()[0] : -1.0;
}

TEST(FloorPressure, IsThatOfFluidsNearFloors) {
  Physics physics = physics_of_two();
  const auto at = [&](const Vec3& cells, std::uint8_t m = 1) {
    ParticleSet particles = particle_at(cells, m, physics);
    particles.real(Field::volume_ratio)[0] = 0.9;
    return pressure_of(physics, particles);
  };
  const double expected = 0.5 * bulk_modulus * (1.0 / 0.9 - 0.9);
  EXPECT_NEAR(at({4.0, 4.0, 1.4}), expected, 1e-9);
  EXPECT_NEAR(at({4.0, 4.0, -0.1}), expected, 1e-9) << "on its way out";
  EXPECT_EQ(at({4.0, 4.0, 1.6}), 0.0);
  EXPECT_EQ(at({4.0, 4.0, 0.5}, 0), 0.0) << "a solid";
  EXPECT_EQ(at({7.5, 4.0, 4.0}), 0.0) << "too steep";
  physics.transfer.order = SplineOrder::cubic;
  EXPECT_NEAR(at({4.0, 4.0, 1.6}), expected, 1e-9);
  const auto is_found = [&] { return at({4.0, 4.0, 0.5}) > 0.0; };
  physics.transfer.thin_layers = false;
  EXPECT_TRUE(is_found()) << "for voids";
  physics.shares_dilation = {1, 0};
  EXPECT_FALSE(is_found()) << "volumes by particles";
  physics.shares_dilation = {0, 1};
  physics.transfer.close_voids = false;
  EXPECT_FALSE(is_found());
  physics.transfer.thin_layers = true;
  EXPECT_FALSE(is_found()) << "no yield stress";
  physics.materials[1].material = HerschelBulkley{{density, bulk_modulus, 3e4, 50.0, 50.0, 0.4}};
  EXPECT_TRUE(is_found()) << "for thin layers";
}

TEST(FloorPressure, IsOfCellsWithAnImplicitPressure) {
  Physics physics = physics_of_two();
  for (NamedMaterial& named : physics.materials) {
    physics.volumetric_laws.push_back(volumetric_law(named.material));
    named.material = without_volumetric_law(named.material);
  }
  ParticleSet particles = particle_at({4.0, 4.0, 0.5}, 1, physics, OptionalFields{Field::cell_mean_stress});
  particles.real(Field::cell_mean_stress)[0] = -300.0;
  EXPECT_EQ(pressure_of(physics, particles), 300.0);
}

// A layer in which sound goes up and down with 1.5 times its pressure: what is left of it is a twelfth, and it presses all the time. When
// nothing lies on the floor any more, that is so after a while, and what lies there then presses at once.
TEST(FloorPressure, DoesNotFollowSound) {
  const Physics physics = physics_of_two();
  const double dx = physics.grid.cell_size, depth = 5.0 * dx, weight = density * 8.0 * depth, pi = std::acos(-1.0);
  const double speed = std::sqrt(bulk_modulus / density), dt = 0.2 * dx / speed, period = 4.0 * depth / speed;
  ParticleSet particles = particle_at({4.0, 4.0, 0.5}, 1, physics, OptionalFields{Field::layer_pressure});
  FloorPressure pressure(physics, block_size);
  const auto found = [&](double now) {
    particles.real(Field::volume_ratio)[0] = std::sqrt(1.0 + std::pow(now / bulk_modulus, 2)) - now / bulk_modulus;
    pressure.find(dt, particles, {0, block_size});
    return pressure.of_block()[0];
  };
  double smallest = weight, largest = weight;
  for (int step = 0; step < 4000; ++step) {
    const double mean = found(weight * (1.0 + 1.5 * std::sin(2.0 * pi * step * dt / period)));
    if (step > 2000) smallest = std::min(smallest, mean), largest = std::max(largest, mean);
  }
  EXPECT_NEAR(smallest, weight, 0.15 * weight);
  EXPECT_NEAR(largest, weight, 0.15 * weight);
  int steps = 0;
  while (found(-0.1 * weight) > 0.0 && steps < 4000) ++steps;
  EXPECT_NEAR(steps * dt, 1.3 * period, 0.3 * period);
  EXPECT_NEAR(found(0.3 * weight), 0.3 * weight, 1e-9 * weight);
}

}  // namespace
}  // namespace bulkley::floor_pressure_mpi_test
