#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "balance/traffic.hpp"
#include "integrator/feed_particles.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/frames/frame.hpp"
#include "rebalance/share.hpp"
#include "simulation/film_warnings.hpp"
#include "simulation/forecast.hpp"
#include "simulation/inflow_warnings.hpp"
#include "simulation/setup.hpp"

namespace bulkley {

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

// Of a lattice of points over the bounds: exact for a rigid motion, whose fastest point is a corner, and near for a field.
double fastest_start(const GridGeometry& grid, const Body& body, const Bounds& box) {
  const int n = body.velocity_field.given() ? 16 : 1;  // intervals per axis
  StartMotion motion(grid, body);
  double fastest = 0.0;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k) {
        const Vec3 part(1.0 * i / n, 1.0 * j / n, 1.0 * k / n);
        const double speed = motion.velocity(box.lower + part.cwiseProduct(box.upper - box.lower)).norm();
        if (speed > fastest) fastest = speed;  // false for NaN, which a field may give outside the body
      }
  return fastest;
}

/// What follows from the speed, the size and the material.
void set_numbers(const Scene& scene, double density, BodyForecast& f) {
  const double u = f.speed;
  const Material& material = scene.materials[f.material_index].material;
  const CharacteristicStress stress =
      characteristic_stress(material, u / f.size).value_or(CharacteristicStress{undefined, undefined});
  f.wave_speed = wave_speed_at_rest(material);
  f.reynolds = density * u * u / stress.total;
  f.bingham = stress.yield / (stress.total - stress.yield);
  f.mach = u / f.wave_speed;
}

BodyForecast body_forecast(const Comm& comm, const Scene& scene, const Body& body) {
  BodyForecast f;
  f.name = body.name;
  f.material = body.material;
  f.material_index = body.material_index;
  Scene alone = scene;
  alone.bodies = {body};
  alone.inflows.clear();
  f.n_particles = gather_census(comm, seeded_census(comm, alone)).n_particles();
  const double dx = scene.grid.cell_size;
  f.mass = static_cast<double>(f.n_particles) * body.density * dx * dx * dx / particles_in_cell(scene.grid, body);

  const Bounds box = bounds(body.shape);
  f.size = (box.upper - box.lower).maxCoeff();
  f.speed = fastest_start(scene.grid, body, box);
  f.at_rest = f.speed == 0.0;
  if (f.at_rest) f.speed = std::sqrt(scene.gravity.norm() * f.size);
  set_numbers(scene, body.density, f);
  return f;
}

/// At the end of the run.
BodyForecast inflow_forecast(const Scene& scene, const Feed& feed) {
  const Inflow& inflow = feed.inflow();
  const double end_time = scene.time_stepping.end_time;
  BodyForecast f;
  f.name = inflow.name;
  f.material = inflow.material;
  f.material_index = inflow.material_index;
  f.n_particles = feed.n_particles(feed.born(end_time));
  f.mass = static_cast<double>(f.n_particles) * inflow.density * feed.particle_volume();
  f.speed = feed.speed_bound(0.0, end_time);
  f.size = std::sqrt(area(inflow.section));
  set_numbers(scene, inflow.density, f);
  return f;
}

// What PETSc keeps of a DMDA for each node, and what it and MPI come to occupy beyond the empty program, bytes: measured
// with PETSc 3.18 and Open MPI 4.1 (docs/performance.md, "Memory").
constexpr double dmda_bytes_per_node = 20.0;
constexpr double library_bytes = 5.0e6;
// The matrix of the pressure, ours and PETSc's, and GAMG for it, of a cell with particles: measured likewise (Jacobi: 7 kB).
constexpr double petsc_bytes_per_cell = 1.0e4;

// Layers of cells that a rank holds of another's, over the layers of nodes that go between the two: 3 of 2 on a plane cut.
constexpr double cut_layers = 1.5;

// What implicit parts add, bytes. A row of the pressure keeps its entries in double and in single precision and where its nodes are.
double implicit_bytes(const Scene& scene, const RankTraffic& rank) {
  const TimeStepSettings& settings = scene.time_stepping;
  if (settings.integrator != IntegratorKind::imex) return 0.0;
  const double width = stencil_width(scene.grid.order);
  const double row = width * width * (width * (sizeof(Node) + 3.0 * sizeof(float)) + sizeof(LocalIndex));
  constexpr double vectors_of_cells = 12.0 * sizeof(double) + 8.0 * sizeof(LocalIndex);
  constexpr double vectors_of_nodes = 5.0 * sizeof(Node) + sizeof(double) + 6.0 * sizeof(LocalIndex);
  constexpr double of_particle = sizeof(double) + sizeof(LocalIndex);  // J at the start of the step; its place in the cell
  const auto n_cells = static_cast<double>(rank.n_cells), n_nodes = static_cast<double>(rank.n_pool_nodes);
  const auto n_particles = static_cast<double>(rank.n_particles);
  // Of other ranks' cells along a cut, with the message that brings their entries and the one that sends as many.
  const double cut_cells = cut_layers * static_cast<double>(rank.bytes_add + rank.bytes_get) / sizeof(Node);
  const double messages = 2.0 * 3.0 * width * width * width * sizeof(double);
  double bytes = n_cells * (row + vectors_of_cells) + cut_cells * (row + vectors_of_cells + messages) +
                 n_nodes * vectors_of_nodes + n_particles * of_particle +
                 static_cast<double>(rank.n_tiles) * tile_nodes * (width * width + 4.0) * sizeof(LocalIndex);
  if (settings.pressure.solver == PressureSolver::petsc) bytes += n_cells * petsc_bytes_per_cell;
  if (settings.viscosity == ViscosityKind::implicit_stress)
    bytes += n_nodes * (7.0 * sizeof(Node) + 3.0 * sizeof(double)) + n_particles * sizeof(double);
  return bytes;
}

// Where volumes are those of cells in the explicit step: the sums of each cell and material, and the group of each particle.
double dilation_bytes(const Scene& scene, const RankTraffic& rank) {
  const std::vector<char> sharing = sharing_materials(scene);
  const auto n_sharing = static_cast<double>(std::ranges::count(sharing, 1));
  const bool by_cell = sharing.size() <= 1 && scene.inflows.empty();
  return n_sharing * sizeof(CellSums) * tile_nodes * static_cast<double>(rank.n_tiles) +
         (by_cell ? 0.0 : sizeof(LocalIndex) * static_cast<double>(rank.n_particles));
}

// Bytes by rank: particles with their work arrays, nodes of the pool and as many owned ones, the map of tiles, implicit parts, and
// where the grid is written its DMDA and a vector.
std::vector<double> memory_estimates(const Scene& scene, const Partition& partition,
                                     const std::vector<RankTraffic>& traffic) {
  const ParticleSet sample(optional_fields(scene));
  // Particles, one column of scratch for sorting, cell and order of each.
  const double per_particle = static_cast<double>(sample.bytes_per_particle()) + 8.0 + 2.0 * sizeof(LocalIndex);
  const double vectors = scene.transfer.n_exchanges();
  const double footprint = std::pow(footprint_width(scene.grid.order), 2);
  const auto tables = static_cast<double>(partition.map.memory());
  std::vector<double> bytes;
  for (const RankTraffic& rank : traffic)
    bytes.push_back(library_bytes + tables + per_particle * static_cast<double>(rank.n_particles) +
                    2.0 * vectors * sizeof(Node) * static_cast<double>(rank.n_pool_nodes) +
                    sizeof(LocalIndex) * (tile_nodes + footprint) * static_cast<double>(rank.n_tiles) +
                    implicit_bytes(scene, rank) + dilation_bytes(scene, rank));
  if (!scene.output.grid) return bytes;
  const FieldBoxes boxes = field_boxes(node_fields(scene.grid), static_cast<int>(bytes.size()));
  for (std::size_t rank = 0; rank < bytes.size(); ++rank)
    bytes[rank] += (sizeof(Node) + dmda_bytes_per_node) * static_cast<double>(boxes.n_nodes(static_cast<int>(rank)));
  return bytes;
}

}  // namespace

double wave_speed_at_rest(const Material& material) {
  return std::visit([](const auto& law) { return std::sqrt(law.wave_speed_squared(state_at_rest(law))); }, material);
}

Forecast forecast(const Comm& comm, const Scene& scene, int n_ranks) {
  check_grid_output(scene);
  Forecast f;
  f.n_ranks = n_ranks;
  StepBounds start;
  for (const Body& body : scene.bodies) {
    f.bodies.push_back(body_forecast(comm, scene, body));
    const BodyForecast& b = f.bodies.back();
    if (!b.at_rest) start.motion.speed.include(b.speed, -1);
    const Material& material = scene.materials[body.material_index].material;
    const Material limiting = explicit_part(scene.time_stepping, material);
    start.motion.wave_speed.include(wave_speed_at_rest(limiting), -1);
    start.motion.viscosity.include(kinematic_viscosity(limiting), -1);
    if (b.mach > 0.3)
      f.warnings.push_back(fmt::format(
          "body '{}' moves at Mach {:.2f}: impacts will compress it noticeably; a larger bulk_modulus makes it stiffer",
          b.name, b.mach));
  }
  for (const std::string& warning : rank_warnings(scene)) f.warnings.push_back(warning);
  for (const std::string& warning : film_warnings(scene, f.bodies)) f.warnings.push_back(warning);
  for (const NamedMaterial& material : scene.materials)
    if (!material.caveat.empty()) f.warnings.push_back(fmt::format("material '{}': {}", material.name, material.caveat));
  const TileCensus census = gather_census(comm, seeded_census(comm, scene));  // the root's; empty elsewhere
  const Physics physics = physics_of(scene);
  include_feeds(physics, 0.0, start);
  for (const std::string& warning : inflow_warnings(scene, physics.feeds)) f.warnings.push_back(warning);
  GlobalIndex n_fed = 0;  // after the start
  for (const Feed& feed : physics.feeds) {
    f.bodies.push_back(inflow_forecast(scene, feed));
    n_fed += f.bodies.back().n_particles - feed.n_particles(feed.born(0.0));
    start.motion.speed.include(f.bodies.back().speed, -1);
  }
  std::vector<GlobalIndex> share;
  std::vector<double> bytes{0.0};
  root_guard(comm, [&] {
    const CostModel cost = assumed_cost(scene);
    const TileLoad load = tile_load(census, cost);
    PartitionNotes notes;
    const Partition partition = make_partition(scene.grid, scene.partition, load, n_ranks, nullptr, cost, &notes);
    f.warnings.insert(f.warnings.end(), notes.warnings.begin(), notes.warnings.end());
    f.boxes = partition.boxes;
    f.method = notes.method;
    const std::vector<RankTraffic> traffic = predict_traffic(scene.grid, partition.map, load);
    for (const RankTraffic& rank : traffic) share.push_back(rank.n_particles);
    f.largest_share = *std::max_element(share.begin(), share.end());
    f.imbalance = imbalance(share);
    bytes = memory_estimates(scene, partition, traffic);
  });
  // What enters, at the end of the run and evenly divided: its columns and work arrays.
  const ParticleSet sample(optional_fields(scene));
  for (double& rank : bytes)
    rank += static_cast<double>(sample.bytes_per_particle() + 24) * static_cast<double>(n_fed) / n_ranks;
  f.n_particles = census.n_particles() + n_fed;
  f.bytes_per_rank = *std::max_element(bytes.begin(), bytes.end());
  f.bytes_per_particle = std::accumulate(bytes.begin(), bytes.end(), 0.0) / static_cast<double>(f.n_particles);

  f.checkpoint_bytes = checkpoint_bytes(optional_fields(scene), f.n_particles);
  if (scene.output.frame_interval > 0.0) {
    f.frame_bytes = frame_bytes(scene.output, optional_fields(scene), scene.grid, f.n_particles);
    f.n_frames = 1 + static_cast<GlobalIndex>(scene.time_stepping.end_time / scene.output.frame_interval * (1.0 + 1e-12));
  }

  f.limit = time_step_limit(limited_by_fall(scene.time_stepping, scene.grid.cell_size, scene.gravity.norm()),
                            scene.grid.cell_size, start, collider_speed(scene.grid, scene.colliders, 0.0, 0.0));
  double dt = f.limit.dt;
  if (scene.time_stepping.mode == TimeStepMode::fixed) {
    const std::string fault = fixed_step_fault(scene.time_stepping, scene.grid.cell_size, start);
    if (!fault.empty() && !scene.time_stepping.allow_unstable) throw UsageError(fault);
    if (!fault.empty()) f.warnings.push_back(fault);
    dt = scene.time_stepping.dt_fixed;
    f.limit = {dt, Limiter::fixed, -1};
  }
  f.n_steps = std::max(1.0, std::ceil(scene.time_stepping.end_time / dt));
  if (scene.time_stepping.mode == TimeStepMode::adaptive) f.choice = compare_integrators(scene, f.bodies);
  // An implicit step is short once the material moves.
  if (f.choice && scene.time_stepping.integrator == IntegratorKind::imex)
    f.n_steps = std::max(f.n_steps, f.choice->imex.n_steps);
  double speed = 0.0;
  for (const BodyForecast& b : f.bodies) speed = std::max(speed, b.speed);
  f.magnetic = magnetic_forecast(scene, n_ranks, speed, scene.time_stepping.end_time / f.n_steps);
  if (f.magnetic) {
    f.bytes_per_rank += f.magnetic->bytes_per_rank;
    f.checkpoint_bytes += f.magnetic->checkpoint_bytes;
    if (f.n_frames > 0 && scene.output.magnetic_field) f.frame_bytes += f.magnetic->frame_bytes;
    f.warnings.insert(f.warnings.end(), f.magnetic->warnings.begin(), f.magnetic->warnings.end());
  }
  if (!scene.rigid_bodies.empty() && scene.time_stepping.integrator == IntegratorKind::explicit_step &&
      scene.transfer.dilation == Dilation::particle)
    f.warnings.push_back(
        "rigid bodies with the explicit step: in fluids they move 5 to 8 % too slowly, more with a higher bulk_modulus, and "
        "have too "
        "large an added mass; transfer.dilation = \"auto\" and time.integrator = \"imex\" have neither fault");
  if (f.n_steps > many_steps)
    f.warnings.push_back(fmt::format(
        "the run needs about {:.2g} steps (more than {:.0g}), because the stiffest material has a wave speed of "
        "{:.4g} m/s; a "
        "smaller bulk_modulus is enough while the Mach number stays below 0.1{}",
        f.n_steps, many_steps, start.motion.wave_speed.value,
        f.choice && f.choice->cheaper == IntegratorKind::imex ? ", and time.integrator = \"imex\" needs none" : ""));
  if (comm.is_root() && n_ranks > 1 && f.largest_share > 0 && *std::min_element(share.begin(), share.end()) == 0)
    f.warnings.push_back(
        fmt::format("{} of {} ranks start without particles", std::count(share.begin(), share.end(), 0), n_ranks));
  return f;
}

}  // namespace bulkley
