#pragma once
// The pressure with which fluids lie on floors, without the sound that goes up and down in them: what tells a void under a weight from
// room that nothing presses on, and how the stress falls in a layer (docs/theory.md, "Voids at floors" and "Thin shear layers").

#include <optional>
#include <vector>

#include "grid/floors.hpp"
#include "integrator/physics.hpp"
#include "material/volumetric_law.hpp"

namespace bulkley {

class FloorPressure {
 public:
  /// For fluids that fill voids (`close_voids`) or shear in layers (`thin_layers`). Particles come in blocks of `block_size`.
  FloorPressure(const Physics& physics, LocalIndex block_size);

  /// Finds the pressures of a block's fluids within reach of the nodes that a floor holds, from positions and the state before the stress
  /// update of a step of dt, s. With the explicit step they are means over some periods of sound (T13h), which `layer_pressure` keeps if
  /// particles have it. Not collective.
  void find(double dt, ParticleSet& particles, ParticleBlock block);
  /// What `find` found, by particle of the block, Pa: 0 away from floors; null without floors and fluids. Not collective.
  const double* of_block() const { return pressures_.empty() ? nullptr : pressures_.data(); }

  std::size_t memory() const { return pressures_.capacity() * sizeof(double); }

 private:
  struct Fluid {
    double density;                           ///< kg/m^3, at rest
    std::optional<VolumetricLaw> volumetric;  ///< none with an implicit pressure
    double sound_speed;                       ///< m/s, at rest; 0 with an implicit pressure
  };

  double reach_;  ///< m, of the nodes that a floor holds
  std::vector<Floor> floors_;
  std::vector<std::optional<Fluid>> fluids_;  ///< by material; none if it does neither
  std::vector<double> pressures_;             ///< by particle of a block; empty without floors or fluids
};

}  // namespace bulkley
