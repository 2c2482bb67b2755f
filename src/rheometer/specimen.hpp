#pragma once
// One material point between the plates: the solver's own particle, driven by the solver's own kernel.

#include <memory>
#include <optional>

#include "bulkley/base/tensor.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "material/material.hpp"

namespace bulkley::rheometer {

/// Homogeneous flows that keep the volume; x is the direction of flow, y that of the gradient.
enum class Flow {
  simple_shear,        ///< strain gamma, L = rate e_x e_y
  uniaxial_extension,  ///< Hencky strain, L = rate diag(1, -1/2, -1/2)
  planar_extension,    ///< Hencky strain, L = rate diag(1, -1, 0)
};

/// The velocity gradient whose step f = 1 + dt L is exactly the finite deformation of a strain `increment`: the extensions
/// of many steps then keep the volume to rounding, which diag(1, -1/2, -1/2) dt would not. Not collective.
Tensor<double> step_gradient(Flow flow, double increment, double dt);

/// A particle of `material`, undeformed, of unit volume, under index 0. Not collective.
ParticleSet make_specimen(const Material& material);

/// What is read off. Cauchy stresses in Pa; tension is positive in normal stresses, compression in the pressure.
struct Reading {
  double shear_stress;              ///< sigma_xy
  double first_normal_difference;   ///< sigma_xx - sigma_yy; in extension the tensile stress
  double second_normal_difference;  ///< sigma_yy - sigma_zz
  double pressure;                  ///< -tr sigma / 3
};

/// Copies share the material and are otherwise independent. Not collective.
class Specimen {
 public:
  explicit Specimen(const Material& material);
  Specimen(const Specimen& other);
  Specimen& operator=(const Specimen& other);

  /// Steps of the kernel. Throws RunError if the kernel refuses the result; the state then is the last good one.
  void advance(Flow flow, double strain_increment, double dt);
  /// The same without the throw; false if refused.
  bool try_advance(const Tensor<double>& velocity_gradient, double dt);

  const Material& material() const { return *material_; }
  Reading read() const;
  double volume_ratio() const;
  /// The particle field "structure" of the laws that have one.
  std::optional<double> structure() const;

 private:
  std::shared_ptr<const Material> material_;
  ParticleSet particles_;
};

/// A specimen compressed isotropically, at once, until its pressure is `pressure` (Pa; 0: undeformed). Throws
/// UsageError if the material cannot take it. Not collective.
Specimen loaded_specimen(const Material& material, double pressure);

}  // namespace bulkley::rheometer
