#pragma once
// Where a fluid with a yield stress lies on a floor that holds it, it shears in a layer that may be thinner than a cell (docs/theory.md, "Thin
// shear layers").

#include <optional>
#include <vector>

#include "grid/floors.hpp"
#include "integrator/physics.hpp"
#include "material/volumetric_law.hpp"

namespace bulkley {

class ShearLayers {
 public:
  /// `physics` must outlive this. Particles come in blocks of `block_size`.
  ShearLayers(const Physics& physics, LocalIndex block_size);

  /// Finds by which part of the yield stress the stress falls from the floor to each particle of a block (T13f), from positions and the
  /// pressures before the stress update: 0 to 1/2, 0 away from sticky floors. With the explicit step pressures are means over some periods
  /// of sound, which `layer_pressure` keeps; dt, s, is that of the step. Not collective.
  void find(double dt, ParticleSet& particles, ParticleBlock block);
  /// What `find` found, for the stress update of a material; null if it does not shear in layers. Not collective.
  const double* of_material(std::size_t m) const { return fluids_[m] ? falls_.data() : nullptr; }

  std::size_t memory() const { return falls_.capacity() * sizeof(double); }

 private:
  struct Fluid {
    double density;                           ///< kg/m^3, at rest
    std::optional<VolumetricLaw> volumetric;  ///< none with an implicit pressure
    double sound_speed;                       ///< m/s, at rest; 0 with an implicit pressure
  };

  std::vector<Floor> floors_;                 ///< sticky ones
  std::vector<double> weights_;               ///< by floor, gravity towards it, m/s^2
  double reach_;                              ///< m, of the nodes that a floor holds
  std::vector<std::optional<Fluid>> fluids_;  ///< by material; none if it does not shear in layers, or there is no such floor
  std::vector<double> falls_;                 ///< by particle of a block; empty without fluids
};

}  // namespace bulkley
