#pragma once
// What a scene says of magnetic fields, the table [magnetics].

#include <optional>
#include <string>
#include <vector>

#include "magnetics/applied_field.hpp"

namespace bulkley {

/// What holds on the faces of the field grid that are not periodic.
enum class FarField {
  robin,    ///< the potential falls as that of a dipole
  zero,     ///< the potential is zero
  neumann,  ///< no flux in addition to that of the sources
};
/// The permeability of nodes that material fills in part.
enum class Mixing {
  spheres,  ///< a dilution of spheres (Maxwell Garnett)
  linear,
  layers,  ///< a layer along the surface, by a tensor; spheres where there is no surface
};
/// The permeability between two nodes.
enum class EdgeMean { harmonic, arithmetic };
/// Who solves for the potential: our conjugate gradients, the same bits on any number of ranks, or PETSc.
enum class FieldSolver { own, petsc };

/// What the names of PETSc's options for that solver begin with.
inline constexpr const char* petsc_magnetics_prefix = "-magnetics_";

struct MagneticsSettings {
  double air = 1.0;            ///< on each side, in extents of the magnetic bodies, >= 0.25
  std::optional<Vec3> origin;  ///< m, of the dipole of FarField::robin; none: centroid of the magnetic content at the start
  FarField boundary = FarField::robin;
  Mixing mixing = Mixing::spheres;
  EdgeMean edges = EdgeMean::harmonic;
  double tolerance = 1e-3;         ///< largest residual over the largest right side, > 0, < 1
  double picard_tolerance = 1e-3;  ///< largest relative change of a permeability, > 0, < 1
  int picard_limit = 8;            ///< sweeps, >= 1
  double resolve_distance = 0.25;  ///< cells that material travels between two solves, > 0
  double largest_interval = 0.0;   ///< s, between two solves; 0: no limit
  FieldSolver solver = FieldSolver::own;
  std::string petsc_options;  ///< for PETSc's solver, each beginning with petsc_magnetics_prefix
  std::vector<FieldSource> sources;
};

}  // namespace bulkley
