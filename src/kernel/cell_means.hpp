#pragma once
// Means over the particles of a material that share a base node, for materials whose volume is a matter of cells
// (docs/theory.md, "Dilation by cells").
//
// All particles with one base node are on one rank, and every sum is order-free: the means have the same bits on any number of
// ranks.

#include <span>

#include "bulkley/base/pack.hpp"
#include "kernel/cells.hpp"
#include "kernel/particle_stress.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

/// Of the particles of one group, weighted by reference volume: sums until means_of_sums, then means but for the volume.
struct CellSums {
  double volume = 0.0;    ///< V = sum V_p, m^3
  double stress = 0.0;    ///< of the mean Kirchhoff stress, tension positive, Pa
  double ratio = 0.0;     ///< of the volume ratio
  double dilation = 0.0;  ///< of the trace of the velocity gradient, 1/s
};

/// The group of each particle, -1: none, it is a matter of its own; and ParticleSet::padding entries that kernels may read.
using CellGroups = std::span<const LocalIndex>;

/// What kernels replace of a particle of a group; empty: nothing of any.
struct CellMeans {
  const LocalIndex* group = nullptr;  ///< by particle
  const CellSums* sums = nullptr;     ///< by group
  double relaxation = 0.0;            ///< share by which a volume ratio goes to its mean in this step

  bool any() const { return group != nullptr; }
  /// The means of n_lanes particles from `p` on; `own` of those without a group.
  Pack of(double CellSums::*mean, LocalIndex p, Pack own) const {
    for (int lane = 0; lane < n_lanes; ++lane)
      if (const LocalIndex g = group[p + lane]; g >= 0) own[lane] = sums[g].*mean;
    return own;
  }
};

/// What the particles' terms are no larger than, the same on every rank.
struct CellSumBounds {
  double volume;        ///< m^3, of a particle
  double stress;        ///< J, V_p ||tau_p||
  double ratio;         ///< J_p
  GlobalIndex n_terms;  ///< particles of a cell
};

/// Sets volume, stress and ratio of `sums` to those of the particles; the rest to zero. Reads volume_ratio,
/// reference_volume, and kirchhoff_stress unless `stress` tells it. Not collective.
void sum_stress(const ParticleSet& particles, CellGroups groups, const CellSumBounds& bounds, std::span<CellSums> sums,
                const StressOfState& stress = {});
/// Divides stress and ratio by the volume. Not collective.
void take_means_of_stress(std::span<CellSums> sums);

/// Adds V_p tr L_p to the dilation of `sums`, L_p as g2p forms it, and divides it by the volume. No term counts more than 1/dt: a particle
/// that goes beyond it inverts. `nodes` as g2p takes them. dt > 0. Not collective.
void find_mean_dilation(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout,
                        const CellMap& map, const Node* nodes, const ParticleSet& particles, CellGroups groups,
                        const CellSumBounds& bounds, double dt, std::span<CellSums> sums);
void find_mean_dilation(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout,
                        const CellMap& map, const NodePair* nodes, const ParticleSet& particles, CellGroups groups,
                        const CellSumBounds& bounds, double dt, std::span<CellSums> sums);

}  // namespace bulkley
