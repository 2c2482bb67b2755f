#include "simulation/setup.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "geometry/mesh_shape.hpp"
#include "integrator/feed_particles.hpp"
#include "integrator/petsc_solver.hpp"
#include "kernel/cells.hpp"
#include "kernel/stress_update.hpp"
#include "magnetostatics/petsc_potential.hpp"
#include "parallel/node_layout.hpp"
#include "rebalance/bisection_partitioner.hpp"
#include "scene/scene_difference.hpp"

namespace bulkley {

std::optional<Magnets> magnets_of(const Scene& scene) {
  if (!scene.magnetics) return std::nullopt;
  constexpr double endless = std::numeric_limits<double>::infinity();
  Magnets magnets{*scene.magnetics, {}, Vec3::Constant(endless), Vec3::Constant(-endless)};
  for (const NamedMaterial& named : scene.materials) magnets.magnetisations.push_back(named.magnetisation);
  for (const Body& body : scene.bodies) {
    if (!magnets.magnetisations[body.material_index]) continue;
    const Bounds box = bounds(body.shape);
    magnets.lower = magnets.lower.cwiseMin(box.lower.cwiseMax(scene.grid.lower));
    magnets.upper = magnets.upper.cwiseMax(box.upper.cwiseMin(scene.grid.upper()));
  }
  return magnets;
}

std::vector<std::string> rank_warnings(const Scene& scene) {
  const auto warning = [](const char* key, const char* own) {
    return fmt::format(
        "{} = \"petsc\": results depend on the number of ranks and on the partition, at the solver's tolerance; "
        "with \"{}\" they are the same bits on any",
        key, own);
  };
  std::vector<std::string> warnings;
  if (scene.time_stepping.pressure.solver == PressureSolver::petsc)
    warnings.push_back(warning("time.pressure.solver", "cg"));
  if (scene.magnetics && scene.magnetics->solver == FieldSolver::petsc)
    warnings.push_back(warning("magnetics.solver", "own"));
  return warnings;
}

void check_petsc_options(const Comm& comm, const Scene& scene) {
  check_petsc_options(comm, scene.time_stepping.pressure);
  check_petsc_options(comm, scene.magnetics.value_or(MagneticsSettings{}));
}

std::vector<char> sharing_materials(const Scene& scene) {
  std::vector<char> shares;
  if (scene.time_stepping.integrator == IntegratorKind::imex || scene.transfer.dilation == Dilation::particle) return shares;
  for (const NamedMaterial& named : scene.materials)
    shares.push_back(volumetric_law(named.material).has_value() &&
                     (scene.transfer.dilation == Dilation::cell || flows(named.material)));
  if (std::ranges::count(shares, 1) == 0) shares.clear();
  return shares;
}

std::vector<NamedMaterial> explicit_materials(const Scene& scene) {
  return explicit_materials(scene.materials, scene.time_stepping.integrator == IntegratorKind::imex,
                            scene.time_stepping.viscosity == ViscosityKind::implicit_stress);
}

Physics physics_of(const Scene& scene) {
  std::vector<Collider> colliders = scene.colliders;
  for (Collider& collider : colliders) collider.shape = sampled_for_contact(collider.shape, scene.grid.cell_size);
  Physics physics{scene.grid,  scene.transfer, scene.time_stepping,      scene.gravity,      explicit_materials(scene),
                  scene.faces, colliders,      scene.acceleration_field, scene.output.gauges};
  physics.time_stepping = limited_by_fall(scene.time_stepping, scene.grid.cell_size, scene.gravity.norm());
  if (scene.time_stepping.integrator == IntegratorKind::imex)
    for (const NamedMaterial& named : scene.materials) physics.volumetric_laws.push_back(volumetric_law(named.material));
  physics.shares_dilation = sharing_materials(scene);
  if (scene.time_stepping.viscosity == ViscosityKind::implicit_stress)
    for (const NamedMaterial& named : scene.materials)
      physics.implicit_viscosities.push_back(separable_viscosity(named.material));
  physics.magnets = magnets_of(scene);
  physics.rigid_bodies = scene.rigid_bodies;
  physics.feeds = feeds_of(scene.grid, scene.inflows, scene.bodies.size(), scene.time_stepping.end_time);
  physics.separate_energies = scene.output.separate_energies;
  return physics;
}

OptionalFields optional_fields(const Scene& scene) {
  OptionalFields fields = internal_fields(explicit_materials(scene));
  if (scene.transfer.needs_velocity_gradient()) fields.insert(Field::velocity_gradient);
  if (scene.time_stepping.integrator == IntegratorKind::imex) fields.insert(Field::cell_mean_stress);
  else if (lies_on_floors(scene))
    fields.insert(Field::layer_pressure);
  if (scene.time_stepping.viscosity == ViscosityKind::implicit_stress) fields.insert(Field::viscous_stress);
  if (scene.magnetics) fields.insert(Field::magnetic_force);
  // Stored only for frames that show them.
  for (const Field field : {Field::magnetic_field, Field::magnetisation, Field::kirchhoff_stress})
    if (std::ranges::count(scene.output.fields, info(field).name) > 0) fields.insert(field);
  return fields;
}

ParticleSet no_particles(const Scene& scene) {
  ParticleSet particles(optional_fields(scene), densities_of(scene.materials));
  particles.hold_block({0, ParticleSet::padding});
  return particles;
}

namespace {

// Of the tiles of the grid that this rank counts in.
TileCensus count_share(const Comm& comm, const GridGeometry& grid, const std::vector<Body>& bodies) {
  const EvenShare tiles = even_share(comm, grid.n_tiles());
  TileCensus census;
  collective_guard(comm, [&] {
    census = count_particles(grid, bodies, static_cast<TileIndex>(tiles.first), static_cast<TileIndex>(tiles.end));
  });
  return census;
}

}  // namespace

namespace {

// The first of the ranks' finds in the order of tiles, on every rank: their shares of the tiles are in the order of ranks.
std::optional<UndefinedMotion> first_undefined_motion(const Comm& comm, const GridGeometry& grid,
                                                      const std::vector<Body>& bodies) {
  const EvenShare tiles = even_share(comm, grid.n_tiles());
  std::optional<UndefinedMotion> found;
  collective_guard(comm, [&] {
    found = find_undefined_motion(grid, bodies, static_cast<TileIndex>(tiles.first), static_cast<TileIndex>(tiles.end));
  });
  const GlobalIndex finder = min_global(comm, GlobalIndex{found ? comm.rank() : comm.size()});
  if (finder == comm.size()) return std::nullopt;
  const bool mine = finder == comm.rank();
  UndefinedMotion first{};
  first.body = static_cast<std::size_t>(max_global(comm, GlobalIndex{mine ? static_cast<GlobalIndex>(found->body) : 0}));
  for (int a = 0; a < 3; ++a)
    first.position[a] = max_global(comm, mine ? found->position[a] : -std::numeric_limits<double>::infinity());
  return first;
}

}  // namespace

BodySurvey shared_survey(const Comm& comm) {
  return {[&comm](const GridGeometry& grid, const std::vector<Body>& bodies) {
            return sum_global(comm, count_share(comm, grid, bodies).n_particles());
          },
          [&comm](const GridGeometry& grid, const std::vector<Body>& bodies) {
            return first_undefined_motion(comm, grid, bodies);
          }};
}

std::vector<std::string> material_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const NamedMaterial& m : scene.materials) names.push_back(m.name);
  return names;
}

void expect_materials(const std::string& file, const std::vector<std::string>& found, const Scene& scene) {
  const std::vector<std::string> names = material_names(scene);
  if (found != names)
    throw UsageError(
        fmt::format("{}: its materials are [{}], those of the scene [{}]: this is a checkpoint of another scene", file,
                    fmt::join(found, ", "), fmt::join(names, ", ")));
}

std::string expect_same_scene(const std::string& file, const std::string& scene_text, const Scene& scene, bool may) {
  constexpr std::size_t n_told = 3;
  const std::vector<std::string> differences = scene_differences(scene_text, scene);
  if (differences.empty()) return {};
  const std::size_t n = std::min(n_told, differences.size());
  std::string text =
      fmt::format("{}: its scene is not this one: {}", file, fmt::join(differences.begin(), differences.begin() + n, "; "));
  if (differences.size() > n) text += fmt::format("; and {} more", differences.size() - n);
  if (!may) throw UsageError(text + "; --changed-scene continues all the same");
  return text + "; continuing with this one";
}

void expect_inside(const GridGeometry& grid, const ParticleSet& particles, const std::string& file) {
  const Vec3 lower = grid.lower, upper = grid.upper();
  for (int axis = 0; axis < 3; ++axis) {
    const double* const x = particles.real(Field::position, axis);
    for (LocalIndex p = 0; p < particles.size(); ++p)
      if (!(x[p] >= lower[axis] && x[p] <= upper[axis]))
        throw UsageError(
            fmt::format("{}: holds particles outside the domain of the scene: this is a checkpoint of another "
                        "scene",
                        file));
  }
}

TileCensus seeded_census(const Comm& comm, const Scene& scene) {
  TileCensus census = count_share(comm, scene.grid, scene.bodies);
  if (scene.inflows.empty()) return census;
  TileCensus all;
  all.n_materials = static_cast<int>(scene.materials.size());
  const auto add = [&all](const TileCensus& some) {
    all.tile.insert(all.tile.end(), some.tile.begin(), some.tile.end());
    all.cells.insert(all.cells.end(), some.cells.begin(), some.cells.end());
    for (std::size_t t = 0; t < some.size(); ++t)
      for (int m = 0; m < all.n_materials; ++m)
        all.count.push_back(m < some.n_materials
                                ? some.count[t * static_cast<std::size_t>(some.n_materials) + static_cast<std::size_t>(m)]
                                : 0);
  };
  add(census);
  if (comm.is_root()) {  // the feeds at the start, which are few
    ParticleSet fed = no_particles(scene);
    append_first_layers(physics_of(scene), TileMap(CutTree(scene.grid)), 0, fed);
    add(take_census(scene.grid, fed, all.n_materials));
  }
  return all;
}

TileTotals tile_totals(const Comm& comm, const GridGeometry& grid, const TileCensus& local, const CostModel& cost) {
  const auto writer_of = [&](TileIndex tile) { return sharer_of(comm, grid.n_tiles(2), grid.tile_coordinates(tile)[2]); };
  SentMessages sent;
  TileLoad load = tile_load(merged_census(comm, local, writer_of, sent), cost);
  TileTotals totals{std::move(load.tile), std::move(load.count), {}};
  for (const GlobalIndex picoseconds : load.weight) totals.cost.push_back(1e-3 * static_cast<double>(picoseconds));
  return totals;
}

CostModel assumed_cost(const Scene& scene) {
  CostModel cost;
  cost.n_exchanges = scene.transfer.n_exchanges();
  return cost;
}

void check_grid_output(const Scene& scene) {
  if (!scene.output.grid) return;
  if (const std::string fault = field_fault(node_fields(scene.grid)); !fault.empty())
    throw UsageError(fmt::format("output.grid = true: {}", fault));
}

Partition first_partition(const Comm& comm, const Scene& scene, const TileCensus& census, const CostModel& cost,
                          std::vector<std::string>* warnings) {
  const NodeLayout nodes = node_layout(comm);
  PartitionSettings settings = scene.partition;
  if (settings.ranks_per_node == 0) settings.ranks_per_node = nodes.ranks_per_node;
  PartitionProposal proposal = make_partitioner(comm, settings)->propose(comm, {scene.grid, census, cost});
  std::vector<std::string>& said = proposal.notes.warnings;  // the root's
  if (const std::string fault = placement_fault(nodes); comm.is_root() && !fault.empty()) said.push_back(fault);
  for (const std::string& warning : said) fmt::print(stderr, "warning: {}\n", warning);
  if (warnings != nullptr) warnings->insert(warnings->end(), said.begin(), said.end());
  BULKLEY_ASSERT(proposal.partition);
  return std::move(*proposal.partition);
}

ParticleSet seed_share(const Comm& comm, const Scene& scene, const Partition& partition, const TileCensus& census) {
  SentMessages sent;
  const TileCensus mine = merged_census(comm, census, owners_or_hash(&partition.map, comm.size()), sent);
  ParticleSet particles = no_particles(scene);
  collective_guard(comm, [&] {
    particles.reserve_more(ParticleSet::checked_size(mine.n_particles()));
    seed_particles(scene.grid, scene.bodies, mine.tile, particles);
  });
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    set_internal_variables(scene.materials[m].material, static_cast<std::uint8_t>(m), particles);
  if (!scene.inflows.empty())
    collective_guard(comm, [&] { append_first_layers(physics_of(scene), partition.map, comm.rank(), particles); });
  return particles;
}

std::unique_ptr<Solver> start_solver(const Comm& comm, const Scene& scene, std::vector<std::string>* warnings) {
  const TileCensus census = seeded_census(comm, scene);
  Partition partition = first_partition(comm, scene, census, assumed_cost(scene), warnings);
  ParticleSet particles = seed_share(comm, scene, partition, census);
  return std::make_unique<Solver>(comm, physics_of(scene), std::move(partition), std::move(particles), std::nullopt);
}

}  // namespace bulkley
