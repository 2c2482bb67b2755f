#pragma once
// Where a fluid with a yield stress lies on a floor that holds it, it shears in a layer that may be thinner than a cell (docs/theory.md, "Thin
// shear layers").

#include <vector>

#include "grid/floors.hpp"
#include "integrator/physics.hpp"

namespace bulkley {

class ShearLayers {
 public:
  /// Particles come in blocks of `block_size`.
  ShearLayers(const Physics& physics, LocalIndex block_size);

  /// Finds by which part of the yield stress the stress falls from the floor to each particle of a block (T13f), from positions, volume
  /// ratios before the stress update, and the block's pressures (FloorPressure): 0 to 1/2, 0 away from sticky floors. Not collective.
  void find(const ParticleSet& particles, ParticleBlock block, const double* pressures);
  /// What `find` found, for the stress update of a material; null if it does not shear in layers. Not collective.
  const double* of_material(std::size_t m) const { return densities_[m] > 0.0 ? falls_.data() : nullptr; }

  std::size_t memory() const { return falls_.capacity() * sizeof(double); }

 private:
  double reach_;                   ///< m, of the nodes that a floor holds
  std::vector<Floor> floors_;      ///< sticky ones
  std::vector<double> densities_;  ///< by material, kg/m^3, at rest; 0 if it does not shear in layers, or there is no such floor
  std::vector<double> falls_;      ///< by particle of a block; empty without such materials
};

}  // namespace bulkley
