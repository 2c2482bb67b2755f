#pragma once
// What a step needs to know of a scene.

#include <vector>

#include "bulkley/base/types.hpp"
#include "config/formula.hpp"
#include "grid/boundary.hpp"
#include "grid/gauge.hpp"
#include "kernel/pressure_cells.hpp"
#include "kernel/transfer.hpp"
#include "material/material.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

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
  /// With implicit viscosity: that of the materials' viscous stress, Pa s, which `materials` then lack. Empty otherwise.
  std::vector<double> implicit_viscosities = {};
};

}  // namespace bulkley
