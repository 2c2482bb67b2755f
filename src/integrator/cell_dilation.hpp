#pragma once
// The explicit step of materials that keep the volume of their particles in a cell together (docs/theory.md, "Dilation by cells").

#include <vector>

#include "integrator/step_parts.hpp"
#include "kernel/cell_means.hpp"

namespace bulkley {

class CellDilation {
 public:
  /// Both must outlive this.
  CellDilation(StepParts& parts, const StressOfState& stress);

  /// Groups the particles as they are at `time` and finds their mean stress and volume ratio, for a step of dt. What an inflow carries
  /// keeps its own. Not collective.
  void begin(double time, double dt);
  /// Then, from the nodes as g2p takes them: the mean dilation. Not collective.
  template <class NodeType>
  void find_dilation(double dt, const NodeType* nodes) {
    const ParticleGrid& grid = parts_.particles;
    find_mean_dilation(grid.grid(), parts_.physics.transfer, grid.layout(), grid.map(), nodes, grid.particles(), groups(),
                       bounds(), dt, sums_);
  }
  /// Of the groups, until particles are handed on.
  CellMeans means() const { return {groups().data(), sums_.data(), relaxation_}; }

  std::size_t memory() const { return groups_.capacity() * sizeof(LocalIndex) + sums_.capacity() * sizeof(CellSums); }

 private:
  CellGroups groups() const;
  CellSumBounds bounds() const;

  StepParts& parts_;
  const StressOfState& stress_;
  std::vector<int> place_of_;  ///< by material, among those that take part; -1: none
  int n_sharing_ = 0;          ///< materials that take part
  double least_density_;       ///< of them, kg/m^3
  bool by_cell_;               ///< the groups are the cells: every particle takes part, and there is one material
  std::vector<LocalIndex> groups_;
  std::vector<CellSums> sums_;
  double relaxation_ = 0.0;
};

}  // namespace bulkley
