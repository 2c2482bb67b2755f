// ranks: 1
// Which materials' particles learn how crowded they are, and what masses are compared with. That J follows, and by how much, is in
// stress_update_test.cpp; what nodes near walls hold, in node_volume_test.cpp.

#include "integrator/crowding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <numeric>

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
      result.push_back(crowding.of_material(m).fullness != nullptr);
      EXPECT_TRUE(!result.back() || crowding.of_material(m).fullness == crowding.of_block().value);
    }
    EXPECT_EQ(crowding.of_block().value != nullptr, result[0] || result[1] || result[2]);
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
  std::fill_n(crowding.of_block().value, block_size, 2.0);
  crowding.spare(nullptr, {16, 32}, 40);
  EXPECT_EQ(crowding.of_block().value[1], 2.0);
  crowding.spare(carried.data(), {16, 32}, 40);
  for (int p = 0; p < block_size; ++p) EXPECT_EQ(crowding.of_block().value[p], p == 1 || p == 4 ? 0.0 : 2.0) << p;
  std::fill_n(crowding.of_block().value, block_size, 2.0);
  crowding.spare(carried.data(), {32, 48}, 34);
  EXPECT_EQ(crowding.of_block().value[1], 0.0);
  EXPECT_EQ(crowding.of_block().value[2], 2.0);
}

// A place at a floor of `VoidsAreAtFloors`.
struct Place {
  int axis;
  double coordinate;  // m
  std::uint8_t material;
  double pressure;  // Pa
  double fullness, slope, missing;
};

constexpr double ratio = 0.99;

ParticleSet particles_at(const std::vector<Place>& places, const GridGeometry& grid) {
  ParticleSet particles;
  particles.resize(static_cast<LocalIndex>(places.size()));
  for (std::size_t p = 0; p < places.size(); ++p) {
    for (int a = 0; a < 3; ++a) particles.real(Field::position, a)[p] = 0.5 * (grid.lower[a] + grid.upper()[a]);
    particles.real(Field::position, places[p].axis)[p] = places[p].coordinate;
    particles.material()[p] = places[p].material;
    particles.real(Field::volume_ratio)[p] = ratio;
  }
  return particles;
}

// With what g2p would leave, along z.
void find_voids(const std::vector<Place>& places, const ParticleSet& particles, Crowding& crowding) {
  const Gathered gathered = crowding.of_block();
  std::vector<double> pressures;
  for (std::size_t p = 0; p < places.size(); ++p) {
    gathered.value[p] = places[p].fullness;
    if (gathered.slope[2]) gathered.slope[2][p] = places[p].slope;
    pressures.push_back(places[p].pressure);
  }
  crowding.find_voids(particles, {0, block_size}, pressures.data());
}

// What is missing is that around fluid that presses on a floor within a cell of it and has material over it; a lighter fluid's is by its
// own density.
TEST(Crowding, VoidsAreAtFloors) {
  Physics physics = physics_of_three();
  physics.shares_dilation = {0, 1, 1};
  physics.gravity = {6.0, 0.0, -8.0};
  const GridGeometry& grid = physics.grid;
  const double dx = grid.cell_size, above = grid.lower[2] + 0.9 * dx;
  const std::vector<Place> places = {
      {2, above, 2, 1.0, 0.5, 0.4, 0.95 - 0.5 * 1.5 * ratio},
      {2, above, 1, 1.0, 0.25, 0.4, 0.95 - 0.25 * 3.0 * ratio},
      {2, above, 2, 1.0, 0.5, 0.1, 0.1 * 1.5},                  // no more than what is above has in addition
      {2, above, 2, 1.0, 0.5, -0.1, 0.0},                       // a film thinner than a cell
      {2, above, 2, 1.0, 0.65, 0.4, 0.0},                       // full for its density
      {2, above, 2, 0.0, 0.5, 0.4, 0.0},                        // does not press
      {2, grid.lower[2] + 1.1 * dx, 2, 1.0, 0.5, 0.4, 0.0},     // too far
      {2, grid.upper()[2] - 0.1 * dx, 2, 1.0, 0.5, -0.4, 0.0},  // a ceiling
      {0, grid.upper()[0] - 0.1 * dx, 2, 1.0, 0.5, 0.4, 0.0},   // too steep
  };
  const ParticleSet particles = particles_at(places, grid);
  Crowding crowding(physics, block_size);
  EXPECT_EQ(crowding.of_material(0).missing, nullptr) << "a solid";
  ASSERT_NE(crowding.of_material(1).missing, nullptr);
  EXPECT_EQ(crowding.of_block().slope[0], nullptr) << "no floor along x";
  find_voids(places, particles, crowding);
  for (std::size_t p = 0; p < places.size(); ++p) EXPECT_NEAR(crowding.of_material(1).missing[p], places[p].missing, 1e-15) << p;
  std::vector<char> carried(places.size(), 0);
  carried[0] = 1;
  crowding.spare(carried.data(), {0, block_size}, particles.size());
  EXPECT_EQ(crowding.of_material(1).missing[0], 0.0);
  EXPECT_GT(crowding.of_material(1).missing[1], 0.0);
  physics.faces[4].kind = FaceKind::outflow;
  Crowding open(physics, block_size);
  find_voids(places, particles, open);
  EXPECT_EQ(open.of_material(1).missing, nullptr) << "no floor";
  physics.transfer.close_voids = false;
  Crowding without(physics, block_size);
  EXPECT_EQ(without.of_material(1).missing, nullptr);
}

// An upper face is a floor where gravity says so, and fullness rises along -z.
TEST(Crowding, VoidsAreAtFloorsOverhead) {
  Physics physics = physics_of_three();
  physics.shares_dilation = {0, 1, 1};
  physics.gravity = {0.0, 0.0, 9.81};
  const double below = physics.grid.upper()[2] - 0.5 * physics.grid.cell_size;
  const std::vector<Place> places = {{2, below, 2, 1.0, 0.5, -0.1, 0.15}, {2, below, 2, 1.0, 0.5, 0.1, 0.0}};
  const ParticleSet particles = particles_at(places, physics.grid);
  Crowding crowding(physics, block_size);
  find_voids(places, particles, crowding);
  for (std::size_t p = 0; p < places.size(); ++p) EXPECT_NEAR(crowding.of_material(1).missing[p], places[p].missing, 1e-15) << p;
}

// The room that they take is not known.
TEST(Crowding, ThereAreNoVoidsBesideMovingColliders) {
  Physics physics = physics_of_three();
  physics.shares_dilation = {0, 1, 1};
  physics.gravity = {0.0, 0.0, -9.81};
  const double dx = physics.grid.cell_size, z = physics.grid.lower[2] + 0.5 * dx;
  const std::vector<Place> places = {{2, z, 2, 1.0, 0.5, 0.4, 0.95 - 0.5 * 1.5 * ratio}};
  const ParticleSet particles = particles_at(places, physics.grid);
  const Vec3 place = particles.vector(Field::position, 0);
  const auto missing = [&](const Vec3& velocity, double cells, double time) {
    Collider ball{"ball", Sphere{place + Vec3((cells + 1.0) * dx, 0.0, 0.0), dx}};
    ball.motion.velocity = velocity;
    physics.colliders = {ball};
    Crowding crowding(physics, block_size);
    crowding.find_moving(time, nullptr);
    find_voids(places, particles, crowding);
    return crowding.of_material(1).missing[0];
  };
  EXPECT_EQ(missing({1.0, 0.0, 0.0}, 1.9, 0.0), 0.0);
  EXPECT_GT(missing({1.0, 0.0, 0.0}, 2.1, 0.0), 0.0);
  EXPECT_GT(missing({1.0, 0.0, 0.0}, 1.9, 0.5 * dx), 0.0) << "it has moved away";
  EXPECT_GT(missing(Vec3::Zero(), 1.9, 0.0), 0.0) << "at rest, its room is known";
}

// Four cells of fluid, 27 particles in each, that press on a floor and are sheared. `skip`: particles that are left out.
SolverScene layer_of_fluid(FaceKind floor, bool close_voids, double shear_rate, const std::function<bool(int)>& skip) {
  SolverScene scene = empty_scene({.close_voids = close_voids}, {4, 4, 8}, {true, true, false});
  Physics& physics = scene.physics;
  physics.shares_dilation = {0, 1};
  physics.gravity = {0.0, 0.0, -9.81};
  physics.faces[4].kind = floor;
  const double spacing = physics.grid.cell_size / 3.0;
  ParticleSet& set = scene.particles;
  set.resize(12 * 12 * 12);
  LocalIndex count = 0;
  for (int p = 0; p < 12 * 12 * 12; ++p) {
    if (skip(p)) continue;
    const Vec3 place = spacing * Vec3(p % 12 + 0.5, p / 12 % 12 + 0.5, p / 144 + 0.5);
    place_particle(set, count, physics.grid.lower + place, std::pow(spacing, 3));
    set.material()[count] = 1;
    set.real(Field::volume_ratio)[count] = 0.995;
    set.set_vector(Field::velocity, count, {shear_rate * place[2], 0.0, 0.0});
    ++count;
  }
  set.resize(count);
  return scene;
}

std::unique_ptr<Solver> solver_alone(const Comm& self, const SolverScene& scene) {
  return solver_of(self, scene, partition_of(self, scene, PartitionMethod::ranges));
}

// By which part of a void a layer sinks that is sheared by 1 over a sticky floor. The lowest third of a cell is half empty, and sound goes up
// and down with twice the layer's weight, so that its lowest cells pull half of the time.
double sunk_part(double bulk_modulus, bool close_voids) {
  const double rate = 20.0, pi = std::acos(-1.0);
  const auto every_other_of_lowest = [](int p) { return p < 144 && (p + p / 12) % 2 == 0; };
  SolverScene scene = layer_of_fluid(FaceKind::sticky, close_voids, rate, every_other_of_lowest);
  Physics& physics = scene.physics;
  physics.materials[1].material = with_bulk_modulus(physics.materials[1].material, bulk_modulus);
  physics.time_stepping.mode = TimeStepMode::adaptive;
  const double density = rest_density(physics.materials[1].material), depth = 4.0 * physics.grid.cell_size;
  const double weight = density * 9.81 * depth, sound = weight / std::sqrt(density * bulk_modulus);  // Pa, m/s
  ParticleSet& set = scene.particles;
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const double height = (set.real(Field::position, 2)[p] - physics.grid.lower[2]) / depth;
    set.real(Field::volume_ratio)[p] = 1.0 - weight * (1.0 - height) / bulk_modulus;
    set.real(Field::velocity, 2)[p] = -2.0 * sound * std::sin(0.5 * pi * height);
  }
  const Comm self(MPI_COMM_SELF);
  const auto solver = solver_alone(self, scene);
  const auto height = [&] {
    const ParticleSet now = gathered(self, solver->particles());
    const double* const z = now.real(Field::position, 2);
    return std::accumulate(z, z + now.size(), 0.0) / now.size();
  };
  const double before = height(), end = 1.0 / rate;
  TimeStepState state;
  for (double time = 0.0; time < end;) time += solver->step({time, end - time}, state).plan.dt;
  return (before - height()) / (physics.grid.cell_size / 6.0);
}

TEST(Crowding, VoidsCloseAtTheSameRateWithAnyModulus) {
  const auto closed = [](double bulk_modulus) { return sunk_part(bulk_modulus, true) - sunk_part(bulk_modulus, false); };
  const double soft = closed(1e6), stiff = closed(16e6);
  EXPECT_GT(soft, 0.25);
  EXPECT_NEAR(stiff, soft, 0.1 * soft);
}

std::vector<double> ratios_after_ten_steps(FaceKind floor, bool close_voids) {
  const SolverScene scene = layer_of_fluid(floor, close_voids, 5.0, [](int) { return false; });
  const Comm self(MPI_COMM_SELF);
  const auto solver = solver_alone(self, scene);
  TimeStepState state;
  double time = 0.0;
  for (int step = 0; step < 10; ++step) time += solver->step({time, 1.0}, state).plan.dt;
  const ParticleSet after = gathered(self, solver->particles());
  return {after.real(Field::volume_ratio), after.real(Field::volume_ratio) + after.size()};
}

// Nodes behind a face that let particles near it look into emptiness would make a void of every floor.
TEST(Crowding, AFullLayerHasNoVoids) {
  for (const FaceKind floor : {FaceKind::sticky, FaceKind::slip, FaceKind::separating})
    EXPECT_EQ(ratios_after_ten_steps(floor, true), ratios_after_ten_steps(floor, false)) << static_cast<int>(floor);
}

}  // namespace
}  // namespace bulkley::crowding_mpi_test
