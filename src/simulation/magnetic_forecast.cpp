#include "simulation/magnetic_forecast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "magnetostatics/magnetic_particles.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

namespace {

// Measured on one quiet core (docs/performance.md): a solution to 1e-3 from the one before, contents and forces included.
constexpr double seconds_per_node = 0.21e-6;
constexpr double layers_factor = 1.8;  // with `mixing = "layers"`
// Magnetostatics::memory with a layer of ghosts on boxes of some 40 nodes across, and PETSc's vectors.
constexpr double numbers_per_node = 40.0;
constexpr double numbers_of_layers = 18.0;  // and with `mixing = "layers"`, likewise
constexpr int n_samples = 7;
constexpr int n_times = 16;

// The strongest applied field in a body at some points of its bounds and some times.
double strongest(const Scene& scene, const AppliedField& field, const Body& body) {
  const Bounds all = bounds(body.shape);
  const Bounds box{all.lower.cwiseMax(scene.grid.lower), all.upper.cwiseMin(scene.grid.upper())};
  double largest = 0.0;
  for (int k = 0; k <= n_times; ++k)
    for (int n = 0; n < n_samples * n_samples * n_samples; ++n) {
      const Vec3 part(n / (n_samples * n_samples), n / n_samples % n_samples, n % n_samples);
      const Vec3 x = box.lower + part.cwiseProduct(box.upper - box.lower) / (n_samples - 1);
      if (signed_distance(body.shape, x) > 1e-9 * scene.grid.cell_size) continue;
      const double strength = field.at(x, scene.time_stepping.end_time * k / n_times).norm();
      if (std::isfinite(strength)) largest = std::max(largest, strength);
    }
  return largest;
}

// M of a ball: H + m(H)/3 = H_0.
double magnetisation_of_ball(const Magnetisation& law, double applied) {
  double low = 0.0, high = applied;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (middle + law.at(middle) / 3.0 > applied ? high : low) = middle;
  }
  return law.at(low);
}

// A flat surface in a normal field grows spikes where nothing resists: neither elasticity nor the yield stress nor weight.
std::optional<std::string> spikes(const Scene& scene, const Body& body, const MagneticBodyForecast& f) {
  const NamedMaterial& named = scene.materials[body.material_index];
  const double susceptibility =
      f.applied > 0.0 ? f.magnetisation / std::max(f.applied - f.magnetisation / 3.0, 1e-300) : 0.0;
  const double drive = 2.0 * f.traction / (1.0 + 1.0 / (1.0 + susceptibility));
  const Bounds box = bounds(body.shape);
  const double weight = body.density * scene.gravity.norm() * (box.upper - box.lower).minCoeff();
  const double speed = shear_wave_speed_at_rest(named.material), elastic = 2.0 * body.density * speed * speed;
  const auto stress = characteristic_stress(at_field(named.material, f.applied), 0.0);
  const double yield = stress && std::isfinite(stress->yield) ? stress->yield : 0.0;
  const double resistance = std::max({elastic, yield, weight});
  if (!(drive > resistance)) return std::nullopt;
  return fmt::format(
      "body '{}': a surface across the field is driven by {:.3g} Pa and held by {:.3g} Pa at most (elasticity {:.3g}, yield "
      "stress "
      "{:.3g}, weight {:.3g}): without surface tension it grows spikes as fine as the cells",
      body.name, drive, resistance, elastic, yield, weight);
}

}  // namespace

std::optional<MagneticForecast> magnetic_forecast(const Scene& scene, int n_ranks, double speed, double dt) {
  if (!scene.magnetics) return std::nullopt;
  const Magnets magnets = *magnets_of(scene);
  const MagneticsSettings& settings = *scene.magnetics;
  const FieldLayout layout = magnetic_layout(scene.grid, magnets.lower, magnets.upper, settings.air);
  const std::vector<LevelShape> shapes = level_shapes(layout);
  MagneticForecast f;
  f.n_nodes = shapes.front().n_nodes;
  f.coarsest = shapes.back().n_nodes;
  f.n_levels = static_cast<int>(shapes.size());
  double n_nodes = 1.0, n_boxes = 1.0;
  for (std::size_t a = 0; a < 3; ++a) n_nodes *= f.n_nodes[a];
  for (int a = 0; a < 3; ++a) n_boxes *= shapes.back().n_cells(a);

  double n_magnetic = 0.0;
  const AppliedField field(settings.sources);
  for (const Body& body : scene.bodies) {
    const auto& law = magnets.magnetisations[body.material_index];
    if (!law) continue;
    MagneticBodyForecast b{body.name, strongest(scene, field, body), 0.0, 0.0};
    b.magnetisation = magnetisation_of_ball(*law, b.applied);
    b.traction = 0.5 * vacuum_permeability * b.magnetisation * b.magnetisation;
    f.bodies.push_back(b);
    speed = std::max(speed, std::sqrt(2.0 * b.traction / body.density));
    if (const auto warning = spikes(scene, body, b)) f.warnings.push_back(*warning);
  }
  for (const auto& law : magnets.magnetisations) n_magnetic += law ? 1.0 : 0.0;
  double bytes_per_node = sizeof(double) * (numbers_per_node + 2.0 * n_magnetic);
  if (settings.mixing == Mixing::layers) bytes_per_node += sizeof(double) * numbers_of_layers;
  if (settings.solver == FieldSolver::petsc) bytes_per_node += PetscPotential::bytes_per_node;
  f.bytes_per_rank = bytes_per_node * n_nodes / std::min<double>(n_ranks, n_boxes);
  constexpr double shown = 8.0;  // numbers of a node in a frame: phi, H, B, theta
  f.checkpoint_bytes = static_cast<GlobalIndex>(n_nodes * sizeof(double));
  f.frame_bytes =
      static_cast<GlobalIndex>(shown * n_nodes * (scene.output.precision == FloatPrecision::float32 ? 4.0 : 8.0));
  f.solve_cost = seconds_per_node * n_nodes * (settings.mixing == Mixing::layers ? layers_factor : 1.0);
  f.steps_a_solve = std::max(1.0, settings.resolve_distance * scene.grid.cell_size / (speed * dt));
  if (f.n_levels < 3)
    f.warnings.push_back(
        fmt::format("the magnetic field has {} levels on {} x {} x {} nodes: more air lets it be solved for faster",
                    f.n_levels, f.n_nodes[0], f.n_nodes[1], f.n_nodes[2]));
  return f;
}

}  // namespace bulkley
