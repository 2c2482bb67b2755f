#include "bench/scene.hpp"

#include <fmt/format.h>

#include <cmath>

#include "material/preset.hpp"
#include "simulation/forecast.hpp"

namespace bulkley {

namespace {

constexpr int particles_per_cell = 8;
constexpr double shear_part = 0.98, fall_part = 0.2;  // of the largest speed; their squares add up to 1

Material material_named(const std::string& name) {
  if (name == "neo_hookean") return NeoHookean{from_youngs_modulus(1000.0, 1e5, 0.3)};  // that of the naive kernel
  if (const auto preset = find_preset(name)) return preset->material;
  throw UsageError(fmt::format("--material {}: not known; one of {}", name, bench_materials()));
}

State<double> rest_state() { return {isochoric_identity<double>(), 1.0}; }

// Speed of the fastest particle, m/s.
double largest_speed(const BenchCase& what) { return what.mach_number * bench_wave_speed(what); }

Material material_of(const BenchCase& what) {
  Material material = material_named(what.material);
  if (what.integrator != IntegratorKind::imex) return material;
  if (!volumetric_law(material))
    throw UsageError(fmt::format(
        "--material {}: imex has nothing to do, for its stress has no part that depends on volume alone", what.material));
  return with_bulk_modulus(material, bench_bulk_modulus);
}

// Moves the grid by two cells at most, so that tiles meet in the middle of the ball along each axis and two, four or eight
// ranks get equal parts: the balance of a partition is not measured here. A ball near its walls is not moved.
void place_tiles(GridGeometry& grid) {
  const double margin = (0.5 - ball_radius) / grid.cell_size;  // cells between the ball and its box
  for (int a = 0; a < 3; ++a) {
    const double middle = (0.5 - grid.lower[a]) / grid.cell_size;
    const double first_boundary = grid.base_shift() - 1.0;  // where base node 0 begins, in cells
    const double boundary = first_boundary + tile_width * std::round((middle - first_boundary) / tile_width);
    if (std::abs(boundary - middle) <= 0.5 * margin) grid.lower[a] -= (boundary - middle) * grid.cell_size;
  }
}

// 1/s: v_x over the height above the middle.
double shear_rate(const BenchCase& what) { return shear_part * largest_speed(what) / ball_radius; }

}  // namespace

double bench_wave_speed(const BenchCase& what) { return wave_speed_at_rest(material_named(what.material)); }

int cells_along_box(const BenchCase& what) {
  const double volume = 4.0 / 3.0 * M_PI * std::pow(ball_radius, 3);
  return static_cast<int>(std::lround(std::cbrt(static_cast<double>(what.n_particles) / (particles_per_cell * volume))));
}

Scene bench_scene(const BenchCase& what) {
  Scene scene;
  scene.title = "bench";
  const int n = cells_along_box(what);
  scene.grid.cell_size = 1.0 / n;
  for (int a = 0; a < 3; ++a) {
    scene.grid.n_cells[a] = n * what.domain[a];
    const int n_below = n * (what.domain[a] - 1) / 2;  // whole cells below the box
    scene.grid.lower[a] = -scene.grid.cell_size * n_below;
  }
  scene.grid.order = what.transfer.order;
  place_tiles(scene.grid);
  scene.transfer = what.transfer;
  scene.gravity = {0.0, 0.0, -what.gravity};
  scene.materials = {{what.material, material_of(what)}};
  const auto preset = find_preset(what.material);
  if (preset && preset->magnetisation && !what.magnetic_field)
    scene.materials.front().material = with_field_yield(scene.materials.front().material, {});
  if (what.magnetic_field) {
    if (preset) scene.materials.front().magnetisation = preset->magnetisation;
    scene.magnetics.emplace();
    scene.magnetics->air = 0.25;
    scene.magnetics->sources.emplace_back().kind = UniformField{VectorFormula{{"2e4", "0", "1e4"}}};
  }
  scene.faces.fill({FaceKind::separating, 0.0});
  scene.time_stepping.end_time = 1.0;
  scene.time_stepping.integrator = what.integrator;
  const Material& material = scene.materials.front().material;
  Body ball;
  ball.name = "ball";
  ball.shape = {Sphere{{0.5, 0.5, 0.5}, ball_radius}};
  ball.material = what.material;
  ball.density = rest_density(material);
  ball.velocity = {0.0, 0.0, -fall_part * largest_speed(what)};
  ball.center = {0.5, 0.5, 0.5};
  ball.particles_per_cell = particles_per_cell;
  ball.lattice = SeedingLattice::jittered;
  scene.bodies = {ball};
  return scene;
}

void start_shear(const BenchCase& what, const Scene& scene, ParticleSet& particles) {
  const Material& material = scene.materials.front().material;
  const double rate = shear_rate(what);
  // The shear is uniform, so one state serves all particles.
  State<double> state = rest_state();
  if (const auto* fluid = std::get_if<HerschelBulkley>(&material)) {
    constexpr double strain = 0.5;  // beyond that of steady flow
    constexpr int n_marches = 200;
    Tensor<double> gradient{};
    gradient(0, 1) = rate;
    for (int march = 0; march < n_marches; ++march)
      fluid->update(state, gradient, strain / rate / n_marches);
  }
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    particles.real(Field::velocity, 0)[p] += rate * (particles.real(Field::position, 1)[p] - 0.5);
    particles.real(Field::affine_velocity, 1)[p] = rate;
    for (int c = 0; c < 6; ++c) particles.real(Field::left_cauchy_green, c)[p] = state.left_cauchy_green.c[c];
    particles.real(Field::volume_ratio)[p] = state.volume_ratio;
  }
}

std::string bench_materials() { return "neo_hookean, " + preset_names(); }

}  // namespace bulkley
