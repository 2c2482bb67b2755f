#pragma once
// Conserved and summary quantities of all particles, for history.csv and the tests.

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "grid/grid_geometry.hpp"
#include "kernel/transfer.hpp"
#include "material/material.hpp"

namespace bulkley {

struct Diagnostics {
  double mass = 0.0;                                ///< kg
  Vec3 momentum = Vec3::Zero();                     ///< kg m/s
  Vec3 angular_momentum = Vec3::Zero();             ///< kg m^2/s about the origin; with the affine part for APIC
  double kinetic_energy = 0.0;                      ///< J, of the particle velocities
  double elastic_energy = 0.0;                      ///< J
  double gravitational_energy = 0.0;                ///< J, -sum m g . x
  double dissipated_energy = 0.0;                   ///< J, by plastic flow since the start
  Vec3 center_of_mass = Vec3::Zero();               ///< m
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();  ///< m, bounding box of the positions
  double yielded_fraction = 0.0;  ///< mass that flowed plastically in the last step over mass of yielding materials
  GlobalIndex n_particles = 0;
};

/// The same bits on any number of ranks: sums are order-free to 2^-100 of the largest term, then rounded once. Collective.
Diagnostics diagnose(const Comm& comm, const GridGeometry& grid, const TransferSettings& transfer, const Vec3& gravity,
                     const std::vector<NamedMaterial>& materials, const ParticleSet& particles);

}  // namespace bulkley
