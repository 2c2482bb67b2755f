#pragma once
// What a step needs to know of a scene.

#include <algorithm>
#include <optional>
#include <vector>

#include "bulkley/base/types.hpp"
#include "config/formula.hpp"
#include "grid/boundary.hpp"
#include "grid/gauge.hpp"
#include "grid/rigid_body.hpp"
#include "kernel/pressure_cells.hpp"
#include "kernel/transfer.hpp"
#include "magnetics/magnetics_settings.hpp"
#include "magnetics/magnetisation.hpp"
#include "material/material.hpp"
#include "particle/inflow.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

/// Magnetic bodies and what acts on them.
struct Magnets {
  MagneticsSettings settings;
  std::vector<std::optional<Magnetisation>> magnetisations;  ///< by material
  Vec3 lower, upper;  ///< m, of the box that holds the magnetic bodies at the start
};

struct Physics {
  GridGeometry grid;
  TransferSettings transfer;
  TimeStepSettings time_stepping;
  Vec3 gravity = Vec3::Zero();  ///< m/s^2
  std::vector<NamedMaterial> materials;
  Faces faces;
  std::vector<Collider> colliders;
  VectorFormula acceleration_field;  ///< m/s^2, of x, y, z, t
  std::vector<Gauge> gauges;
  /// With an implicit pressure: the volumetric parts of the materials' laws, which `materials` then lack. Empty otherwise.
  VolumetricLaws volumetric_laws = {};
  /// By material, whether its volume is a matter of cells in the explicit step. Empty: of no material.
  std::vector<char> shares_dilation = {};
  /// With implicit viscosity: that of the materials' viscous stress, Pa s, which `materials` then lack. Empty otherwise.
  std::vector<double> implicit_viscosities = {};
  std::optional<Magnets> magnets = {};
  std::vector<RigidBody> rigid_bodies = {};
  std::vector<Feed> feeds = {};
  /// The energy budget tells the transfer to the grid from the time integration with every transfer, at the cost of a scatter of
  /// momenta and impulses apart where they are summed in one otherwise.
  bool separate_energies = false;

  /// Whether the volume of some material is that of cells, not of particles: by an implicit pressure or by shared dilation.
  bool keeps_volume_of_cells() const { return !volumetric_laws.empty() || !shares_dilation.empty(); }
  /// Likewise that of material m.
  bool keeps_volume_of_cells(std::size_t m) const {
    return volumetric_laws.empty() ? !shares_dilation.empty() && shares_dilation[m] : volumetric_laws[m].has_value();
  }
  /// Of all materials, kg/m^3; 0 without any.
  double largest_density() const {
    double density = 0.0;
    for (const NamedMaterial& named : materials)
      density = std::max(density, rest_density(named.material));
    return density;
  }
  /// Places of contact beside the faces: the colliders, then the feeds. Rigid bodies come after them.
  std::size_t n_obstacles() const { return colliders.size() + feeds.size(); }
};

}  // namespace bulkley
