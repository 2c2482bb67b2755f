#pragma once
// Everything in a scene file.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "balance/partition_settings.hpp"
#include "bulkley/config/rule.hpp"
#include "grid/boundary.hpp"
#include "grid/rigid_body.hpp"
#include "kernel/transfer.hpp"
#include "magnetics/magnetics_settings.hpp"
#include "material/material.hpp"
#include "particle/inflow.hpp"
#include "particle/seeding.hpp"
#include "scene/output_settings.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

struct Scene {
  std::string title;
  GridGeometry grid;
  Vec3 gravity{0.0, 0.0, -9.81};     ///< m/s^2
  VectorFormula acceleration_field;  ///< m/s^2, of x, y, z, t; added to gravity
  TransferSettings transfer;
  TimeStepSettings time_stepping;
  std::vector<NamedMaterial> materials;
  std::optional<MagneticsSettings> magnetics;
  std::vector<Body> bodies;
  bool allow_overlap = false;  ///< bodies may overlap; the first in the file wins
  std::vector<Inflow> inflows;
  Faces faces;
  std::vector<Collider> colliders;
  std::vector<RigidBody> rigid_bodies;
  OutputSettings output;
  CheckpointSettings checkpoint;
  PartitionSettings partition;
  std::vector<std::string> body_places;      ///< "file:line:column" of each body, for messages; may be empty
  std::vector<std::string> collider_places;  ///< of each collider
  std::vector<std::string> rigid_places;     ///< of each rigid body
  std::string effective_text;                ///< the effective input as TOML; parsing it gives this scene again
  std::vector<std::string> warnings;         ///< about accepted input, each "file:line:column: sentence"
};

/// Parses and checks a scene. `overrides`: "key.path=value" strings; entries of a list go by index or name
/// ("bodies.0.velocity=[0,0,-1]", "bodies.ball.material=pie"); a value that is not TOML is taken as text.
/// Throws UsageError with one sentence per fault and line, each "file:line:column: ..." or "--set key.path=value: ...".
/// Not collective: every rank parses the same text.
Scene parse_scene(const std::string& text, const std::string& file_name, const std::vector<std::string>& overrides);

/// The effective input of a scene as TOML: every key, defaults included. Not collective.
std::string effective_text(const Scene& scene);

/// How the lattice points of bodies in a grid are visited: by one rank alone or by several, each in a share of the tiles.
struct BodySurvey {
  std::function<GlobalIndex(const GridGeometry& grid, const std::vector<Body>& bodies)> count;  ///< of their particles
  std::function<std::optional<UndefinedMotion>(const GridGeometry& grid, const std::vector<Body>& bodies)>
      find_undefined_motion;  ///< the first in the order of tiles
};

/// On this rank alone. Not collective.
BodySurvey survey_alone();

/// What the shapes' geometry says about a parsed scene: every body inside the domain, holding at least one particle, and
/// overlapping no other unless the scene allows it (by the particles it would get, hence more expensive than parsing), and a
/// motion that is defined at each of its particles. Throws UsageError with one sentence per fault and line. Collective if
/// `survey` is.
void check_bodies(const Scene& scene, const BodySurvey& survey = survey_alone());

/// Every inflow has a section of particles and a rate that is defined, and its feed stays inside the domain, out of colliders and
/// of seeded material. Throws UsageError with one sentence per fault and line. Needs meshes and key frames. Not collective (the same
/// on every rank).
void check_inflows(const Scene& scene);

/// Colliders must be thicker than two cells: a thinner one does not keep the material on its two sides apart. Throws
/// UsageError with one sentence per fault and line, each with the required thickness. Not collective (the same on every
/// rank).
void check_colliders(const Scene& scene);

/// Rigid bodies must have a mass, be thicker than two cells and fit into a period, and reach into no wall, collider, body or material by more
/// than half a cell. Throws UsageError with one sentence per fault and line. Needs meshes. Not collective (the same on every rank).
void check_rigid_bodies(const Scene& scene);

/// No magnetic material in a magnet or on a wire at the start; formulas of fields are without divergence and curl in magnetic bodies,
/// up to a hundredth of |H| over the body's size. Throws UsageError with one sentence per fault and line. Needs the bodies' meshes.
/// Not collective (the same on every rank).
void check_magnetics(const Scene& scene);

/// The patch of each gauge must hold some of its wall. Throws UsageError with one sentence per fault and line. Needs the
/// colliders' meshes. Not collective (the same on every rank).
void check_gauges(const Scene& scene);

/// Whether the pressure with which fluids lie on floors matters: some fill voids there, or shear in layers (docs/theory.md, "Voids at floors"
/// and "Thin shear layers"). Not collective.
bool lies_on_floors(const Scene& scene);

/// Name of a collider, front or gauge as the names of its columns in history.csv begin. Not collective.
std::string column_prefix(const std::string& name);

/// Every key by table, in the order of docs/input.md. Not collective.
std::vector<config::TableText> input_tables();

/// The page docs/input.md: every key with type, unit, default, range and meaning, in Markdown. Not collective.
std::string input_reference();

}  // namespace bulkley
