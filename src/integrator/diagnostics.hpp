#pragma once
// Conserved and summary quantities of all particles, measured.

#include "bulkley/integrator/diagnostics.hpp"
#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "grid/grid_geometry.hpp"
#include "kernel/transfer.hpp"
#include "material/material.hpp"

namespace bulkley {

/// D of the kinetic energy (m / 2)(|v|^2 + D |C|^2) of a particle, m^2; 0 for transfers without an affine part. Not
/// collective.
double affine_inertia(const GridGeometry& grid, const TransferSettings& transfer);

/// The same bits on any number of ranks: sums are order-free to 2^-100 of the largest term, then rounded once. Collective.
Diagnostics diagnose(const Comm& comm, const GridGeometry& grid, const TransferSettings& transfer, const Vec3& gravity,
                     const std::vector<NamedMaterial>& materials, const ParticleSet& particles);

}  // namespace bulkley
