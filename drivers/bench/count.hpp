#pragma once
// The work of one step, counted by hand from the algorithm: docs/performance.md, "The floor".

#include <vector>

#include "kernel/transfer.hpp"

namespace bulkley {

/// One part of a step's work on a particle.
struct WorkTerm {
  const char* what;
  double bytes = 0.0;  ///< between memory and caches; a line that is written without having been read is read first
  double flops = 0.0;  ///< a fused product and sum counts as two, a division or a root as one
};

/// What the count depends on in addition to the transfer.
struct WorkCase {
  TransferSettings transfer;
  bool flows = false;               ///< the material has a yield surface
  bool shares_dilation = false;     ///< its particles keep their volume by cells
  bool stores_stress = false;       ///< else it follows from b and J
  double sorts_per_step = 0.0;      ///< physical sorts
  double nodes_per_particle = 0.0;  ///< grid nodes that particles reach
};

/// All parts of a step on one rank, per particle. Not collective.
std::vector<WorkTerm> count_work(const WorkCase& work);

/// Bytes of one iteration of PotentialSolver, per node of the finest level: docs/performance.md, "Magnetic fields".
inline constexpr double bytes_of_potential = 579.0;

}  // namespace bulkley
