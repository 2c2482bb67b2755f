#pragma once
// Small scenes for the real solver under MPI, and its particles gathered from all ranks.

#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "grid/floors.hpp"
#include "integrator/solver.hpp"
#include "kernel/stress_update.hpp"
#include "support/particle_builders.hpp"
#include "support/tile_loads.hpp"

namespace bulkley {

/// Neo-Hookean (0) and Herschel-Bulkley (1).
inline std::vector<NamedMaterial> solid_and_fluid() {
  return {{"solid", NeoHookean{{1000.0, 1e5, 3e4}}}, {"fluid", HerschelBulkley{{800.0, 1e5, 3e4, 50.0, 20.0, 0.4}}}};
}

/// A scene and all its particles, the same on every rank.
struct SolverScene {
  Physics physics;
  ParticleSet particles{OptionalFields{}, densities_of(solid_and_fluid())};
};

/// Appends a block of n[0] x n[1] x n[2] particles, two per cell and axis, its lowest corner at `corner`.
inline void add_block(SolverScene& scene, const Vec3& corner, const Int3& n, std::uint8_t material, const Vec3& velocity) {
  ParticleSet& set = scene.particles;
  const double spacing = 0.5 * scene.physics.grid.cell_size, volume = spacing * spacing * spacing;
  LocalIndex p = set.size();
  set.resize(p + n[0] * n[1] * n[2]);
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k, ++p) {
        place_particle(set, p, corner + spacing * Vec3(i + 0.5, j + 0.5, k + 0.5), volume);
        set.material()[p] = material;
        // A little disorder, so that no two particles move alike.
        set.set_vector(Field::velocity, p, velocity + 0.2 * Vec3(std::sin(3.0 * p), std::sin(5.0 * p), std::sin(7.0 * p)));
      }
}

/// Appends one particle of the solid at rest.
inline void add_particle(SolverScene& scene, const Vec3& x, const Vec3& velocity = Vec3::Zero()) {
  const double spacing = 0.5 * scene.physics.grid.cell_size, volume = spacing * spacing * spacing;
  const LocalIndex p = scene.particles.size();
  scene.particles.resize(p + 1);
  place_particle(scene.particles, p, x, volume);
  scene.particles.set_vector(Field::velocity, p, velocity);
}

inline SolverScene empty_scene(const TransferSettings& transfer, const Int3& n_cells, const std::array<bool, 3>& periodic) {
  SolverScene scene;
  Physics& physics = scene.physics;
  physics.grid = {
      .lower = Vec3(-0.3, 0.2, 0.1), .cell_size = 0.1, .n_cells = n_cells, .periodic = periodic, .order = transfer.order};
  physics.transfer = transfer;
  physics.materials = solid_and_fluid();
  physics.time_stepping.mode = TimeStepMode::fixed;
  physics.time_stepping.dt_fixed = 1e-3;
  for (std::size_t f = 0; f < 6; ++f) physics.faces[f].kind = periodic[f / 2] ? FaceKind::periodic : FaceKind::slip;
  return scene;
}

/// A solid and a fluid block side by side on a rough floor, a ball in their way, particles on the faces and corners.
inline SolverScene contact_scene(const TransferSettings& transfer) {
  SolverScene scene = empty_scene(transfer, {8, 8, 8}, {false, false, false});
  Physics& physics = scene.physics;
  physics.gravity = Vec3(0.0, 0.0, -9.81);
  physics.faces[0] = {FaceKind::sticky, 0.0, Vec3(0.0, 0.2, -0.1)};
  physics.faces[4] = {FaceKind::separating, 0.3};
  Collider& ball = physics.colliders.emplace_back();
  ball.name = "ball";
  ball.shape = {Sphere{Vec3(0.35, 0.6, 0.15), 0.12}};
  ball.contact = Contact::separating;
  ball.friction = 0.2;
  const Vec3 lower = physics.grid.lower, upper = physics.grid.upper();
  add_block(scene, lower + Vec3(0.1, 0.2, 0.0), {5, 6, 4}, 0, Vec3(1.0, 0.0, -1.0));
  add_block(scene, lower + Vec3(0.4, 0.2, 0.05), {4, 6, 4}, 1, Vec3(-1.0, 0.0, -2.0));
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = corner >> a & 1 ? upper[a] : lower[a];
    add_particle(scene, x, Vec3(0.3, -0.2, 0.1));
  }
  add_particle(scene, Vec3(lower[0], 0.6, 0.5), Vec3(-0.5, 0.5, 0.0));
  add_particle(scene, Vec3(0.1, upper[1], 0.5), Vec3(0.0, 0.5, 0.3));
  return scene;
}

/// The same under an adaptive step that is tried twice as long every other time, and rejected where it deforms too much.
inline SolverScene judged_scene(const TransferSettings& transfer) {
  SolverScene scene = contact_scene(transfer);
  scene.physics.time_stepping = {};
  scene.physics.time_stepping.trial_interval = 2;
  scene.physics.time_stepping.growth = 2.0;
  scene.physics.time_stepping.deformation_limit = 2e-3;
  return scene;
}

/// A solid and a fluid block that meet across the edges of a box whose axes, or some of them, are periodic.
inline SolverScene periodic_scene(const TransferSettings& transfer, const Int3& n_cells,
                                  const std::array<bool, 3>& periodic) {
  SolverScene scene = empty_scene(transfer, n_cells, periodic);
  const Vec3 lower = scene.physics.grid.lower, upper = scene.physics.grid.upper();
  add_block(scene, lower, {5, 6, 4}, 0, Vec3(-2.0, 1.0, 0.5));
  add_block(scene, lower + Vec3(0.45, 0.0, 0.1), {4, 6, 5}, 1, Vec3(2.0, -1.0, -1.0));
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) {
      const bool high = corner >> a & 1;
      x[a] = !high ? lower[a] : periodic[static_cast<std::size_t>(a)] ? std::nextafter(upper[a], lower[a]) : upper[a];
    }
    add_particle(scene, x, Vec3(0.3, -0.2, 0.1));
  }
  return scene;
}

/// A block of every law, each thrown against its neighbours: two rows of five over a floor.
inline SolverScene every_law_scene(const TransferSettings& transfer) {
  SolverScene scene = empty_scene(transfer, {12, 8, 8}, {false, false, false});
  Physics& physics = scene.physics;
  physics.gravity = Vec3(0.0, 0.0, -9.81);
  physics.faces[4] = {FaceKind::separating, 0.3};
  const NeoHookean::Parameters stiff{1000.0, 1e5, 3e4};
  const HerschelBulkley::Parameters flow{1000.0, 1e5, 3e4, 50.0, 20.0, 0.4, 0.5};
  ThixotropicHerschelBulkley::Parameters thixotropic{flow};
  thixotropic.build_up = 1.0;
  thixotropic.breakdown = 0.5;
  DruckerPrager::Parameters sand{stiff};
  sand.friction_angle = 30.0;
  sand.cohesion = 50.0;
  sand.hardening_drop = 5.0;
  physics.materials = {{"neo_hookean", NeoHookean{stiff}},
                       {"herschel_bulkley", HerschelBulkley{flow}},
                       {"hencky", Hencky{stiff}},
                       {"fixed_corotated", FixedCorotated{stiff}},
                       {"newtonian", Newtonian{{1000.0, 1e5, 3.0}}},
                       {"oldroyd_b", OldroydB{{1000.0, 1e5, 1e3, 0.02, 1.0}}},
                       {"finite_viscoelastic", FiniteViscoelastic{{stiff, 1e4, 1e4, 0.01, 0.02}}},
                       {"thixotropic", ThixotropicHerschelBulkley{thixotropic}},
                       {"sand", DruckerPrager{sand}},
                       {"snow", Snow{{stiff, 1e-2, 5e-3, 5.0}}}};
  scene.particles = ParticleSet(internal_fields(physics.materials), densities_of(physics.materials));
  for (int m = 0; m < 10; ++m)
    add_block(scene, physics.grid.lower + Vec3(0.1 + 0.2 * (m % 5), 0.2 + 0.2 * (m / 5), 0.05), {4, 4, 4},
              static_cast<std::uint8_t>(m), Vec3(m % 2 == 0 ? 1.5 : -1.5, m < 5 ? 1.0 : -1.0, -1.0));
  for (std::size_t m = 0; m < physics.materials.size(); ++m)
    set_internal_variables(physics.materials[m].material, static_cast<std::uint8_t>(m), scene.particles);
  return scene;
}

/// Gives the scene integrator imex: all materials that have a volumetric part with the bulk modulus of water.
inline void make_implicit(Physics& physics) {
  physics.time_stepping.integrator = IntegratorKind::imex;
  for (NamedMaterial& named : physics.materials) {
    physics.volumetric_laws.push_back(volumetric_law(with_bulk_modulus(named.material, 2.2e9)));
    named.material = without_volumetric_law(named.material);
  }
}

/// Steps as long as what remains, none of them judged: to hand the scene those of another run.
inline void take_handed_steps(Physics& physics) {
  physics.time_stepping.mode = TimeStepMode::fixed;
  physics.time_stepping.dt_fixed = 1.0;
  physics.time_stepping.allow_unstable = true;
}

/// The transfers whose code paths differ most, for tests that need not run through all.
inline std::vector<TransferSettings> some_transfers() {
  return {{.scheme = TransferScheme::apic, .order = SplineOrder::quadratic, .gradient = GradientForm::mls},
          {.scheme = TransferScheme::apic,
           .order = SplineOrder::cubic,
           .gradient = GradientForm::bspline,
           .affine_damping = 0.1},
          {.scheme = TransferScheme::blend, .order = SplineOrder::quadratic, .gradient = GradientForm::bspline},
          {.scheme = TransferScheme::flip, .order = SplineOrder::cubic, .gradient = GradientForm::mls},
          {.scheme = TransferScheme::moment_flip, .damping_time = 0.01}};
}

/// A partition of the scene's grid by its particles; where there are no boxes, `hilbert` takes the place of methods that
/// need them. `scattered`: neighbouring tiles at any ranks.
inline Partition partition_of(const Comm& comm, const SolverScene& scene, PartitionMethod method, bool scattered = false) {
  std::vector<GlobalIndex> load(static_cast<std::size_t>(scene.physics.grid.n_tiles()), 0);
  for (LocalIndex p = 0; p < scene.particles.size(); ++p)
    ++load[static_cast<std::size_t>(scene.physics.grid.tile_of(scene.particles.vector(Field::position, p)))];
  const bool needs_boxes = method == PartitionMethod::uniform || method == PartitionMethod::ranges;
  if (needs_boxes && !box_fault(scene.physics.grid, comm.size()).empty()) method = PartitionMethod::hilbert;
  Partition partition = make_partition(scene.physics.grid, {method}, tile_load(load), comm.size());
  if (scattered) partition.map = scattered_map(scene.physics.grid, comm.size());
  return partition;
}

/// Every n-th particle, so that each has to find its way to its rank.
inline ParticleSet share_of(const Comm& comm, const ParticleSet& all, OptionalFields fields) {
  std::vector<LocalIndex> mine;
  for (LocalIndex p = comm.rank(); p < all.size(); p += comm.size()) mine.push_back(p);
  return picked(all, mine, fields);
}

/// What particles of the scene hold in addition to the fields that all have. Not collective.
inline OptionalFields fields_of(const Physics& physics) {
  OptionalFields fields = internal_fields(physics.materials);
  if (physics.transfer.needs_velocity_gradient()) fields.insert(Field::velocity_gradient);
  if (!physics.volumetric_laws.empty()) fields.insert(Field::cell_mean_stress);
  else if (!floors_of(physics.grid, physics.faces, physics.gravity).empty())
    fields.insert(Field::layer_pressure);
  return fields;
}

/// A solver at the scene's start. Collective.
inline std::unique_ptr<Solver> solver_of(const Comm& comm, const SolverScene& scene, Partition partition) {
  return std::make_unique<Solver>(comm, scene.physics, std::move(partition),
                                  share_of(comm, scene.particles, fields_of(scene.physics)), std::nullopt);
}

/// All particles of all ranks on every rank, ascending by id, without what lives within one step. Collective.
inline ParticleSet gathered(const Comm& comm, const ParticleSet& local) {
  std::vector<int> counts(static_cast<std::size_t>(comm.size())), starts(counts.size(), 0);
  const int n_local = local.size();
  BULKLEY_MPI(MPI_Allgather(&n_local, 1, MPI_INT, counts.data(), 1, MPI_INT, comm.get()));
  for (std::size_t r = 1; r < starts.size(); ++r) starts[r] = starts[r - 1] + counts[r - 1];
  OptionalFields moving;
  for (const FieldInfo& field : field_table)
    if (field.optional && field.moves && local.has(field.field)) moving.insert(field.field);
  ParticleSet all(moving, local.densities());
  all.resize(starts.back() + counts.back());
  std::size_t to = 0;
  for (std::size_t from = 0; from < local.columns().size(); ++from) {
    if (!local.columns()[from].moves) continue;
    const MPI_Datatype type = local.columns()[from].element_size == 1 ? MPI_UINT8_T : MPI_INT64_T;
    BULKLEY_MPI(
        MPI_Allgatherv(local.data(from), n_local, type, all.data(to), counts.data(), starts.data(), type, comm.get()));
    ++to;
  }
  std::vector<LocalIndex> order(static_cast<std::size_t>(all.size()));
  for (LocalIndex p = 0; p < all.size(); ++p) order[static_cast<std::size_t>(p)] = p;
  std::sort(order.begin(), order.end(), [&](LocalIndex a, LocalIndex b) { return all.id()[a] < all.id()[b]; });
  return picked(all, order);
}

}  // namespace bulkley
