#pragma once
// From a scene to particles on their ranks.

#include <string>
#include <vector>

#include "balance/partition.hpp"
#include "base/named_numbers.hpp"
#include "integrator/solver.hpp"
#include "scene/scene.hpp"

namespace bulkley {

/// What runs and checks warn of where the scene's solvers make the integrator inexact (Integrator::is_exact). Not collective.
std::vector<std::string> rank_warnings(const Scene& scene);

/// Throws UsageError where options for one of PETSc's solvers are not understood, those of the scene or those after "--". Collective.
void check_petsc_options(const Comm& comm, const Scene& scene);

/// By material, whether its particles keep the volume of cells in the explicit step; empty where none do.
std::vector<char> sharing_materials(const Scene& scene);

/// The part of a scene that the solver needs.
Physics physics_of(const Scene& scene);

/// Its magnetic bodies; none without [magnetics]. Needs the bodies' meshes. Not collective.
std::optional<Magnets> magnets_of(const Scene& scene);

/// The fields that the scene's particles have in addition to those that all have. Not collective.
OptionalFields optional_fields(const Scene& scene);
/// The scene's materials without what an implicit pressure or viscosity takes from them. Not collective.
std::vector<NamedMaterial> explicit_materials(const Scene& scene);

/// An empty set with these fields. What does not move is held for a block from the start, so that it never takes the memory of all
/// particles. Not collective.
ParticleSet no_particles(const Scene& scene);

/// A survey in which each rank visits a share of the tiles; its calls are collective. `comm` must outlive it.
BodySurvey shared_survey(const Comm& comm);

/// Names of the scene's materials, in its order. Not collective.
std::vector<std::string> material_names(const Scene& scene);

/// Throws UsageError unless `found`, the materials of the checkpoint `file`, are those of the scene. Not collective.
void expect_materials(const std::string& file, const std::vector<std::string>& found, const Scene& scene);

/// Throws UsageError if the scene differs from the one in the checkpoint `file` (scene_differences) with the first keys that
/// do, or returns that sentence if it `may` differ; empty if it does not. Not collective.
std::string expect_same_scene(const std::string& file, const std::string& scene_text, const Scene& scene, bool may);

/// Throws UsageError if a particle of the checkpoint `file` lies outside the domain. Not collective.
void expect_inside(const GridGeometry& grid, const ParticleSet& particles, const std::string& file);

/// What this rank's share of the tiles holds at the scene's start; each tile is in the share of one rank, and what feeds hold in
/// that of the root. Collective.
TileCensus seeded_census(const Comm& comm, const Scene& scene);

/// What tiles hold and their estimated cost (tile_load).
struct TileTotals {
  std::vector<TileIndex> tile;  ///< those with particles, ascending
  std::vector<GlobalIndex> n_particles;
  std::vector<double> cost;  ///< ns a step
};
/// Of the ranks' censuses together, in the planes of tiles across z that are this rank's even_share. Collective.
TileTotals tile_totals(const Comm& comm, const GridGeometry& grid, const TileCensus& local, const CostModel& cost);

/// What steps cost according to a checkpoint (CheckpointHeader::reals); the default where it does not say. Not collective.
CostModel load_cost(const Reals& reals);

/// What steps of the scene cost before any is measured. Not collective.
CostModel assumed_cost(const Scene& scene);

/// Refuses frames of a grid that PETSc cannot number. Throws UsageError. Not collective.
void check_grid_output(const Scene& scene);

/// The scene's partition for as many ranks as there are, on every rank; warnings on the root's stderr, and added to its `warnings`
/// if they are given. `census`: of this rank's particles, or its share of the counts (PartitionRequest). Throws UsageError.
/// Collective.
Partition first_partition(const Comm& comm, const Scene& scene, const TileCensus& census, const CostModel& cost,
                          std::vector<std::string>* warnings = nullptr);

/// The particles of the tiles that `partition` gives to this rank. `census`: of the start, this rank's share of it (seeded_census), from
/// which the ranks learn which tiles those are, without looking at all. Collective.
ParticleSet seed_share(const Comm& comm, const Scene& scene, const Partition& partition, const TileCensus& census);

/// A solver at the scene's start: the partition is made first, from counted particles, so that no rank ever holds much more
/// than its share. `warnings` as of first_partition. Collective.
std::unique_ptr<Solver> start_solver(const Comm& comm, const Scene& scene, std::vector<std::string>* warnings = nullptr);

}  // namespace bulkley
