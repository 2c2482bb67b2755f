#pragma once
// The stress of particles: stored, or from their strain where that takes a few operations.

#include <span>
#include <vector>

#include "bulkley/base/tensor.hpp"
#include "bulkley/particle/particle_set.hpp"
#include "kernel/batch.hpp"
#include "material/material.hpp"

namespace bulkley {

/// By what part of rho_0 c^2 two computations of a stress from the same state may differ; rounding makes less.
inline constexpr double stress_rounding = 1e-14;

/// Materials without what an implicit pressure or an implicit viscosity takes from them. Not collective.
std::vector<NamedMaterial> explicit_materials(std::span<const NamedMaterial> materials, bool implicit_pressure,
                                              bool implicit_viscosity);

/// The neo-Hookean solids by whose stress (T16) particles are stressed, by material. Not stored is what follows from b and J.
class StressOfState {
 public:
  /// Of none: stresses are stored.
  StressOfState() = default;
  /// Of none unless every material has one (neo_hookean_stress). Not collective.
  explicit StressOfState(std::span<const NamedMaterial> materials);
  /// As frames show particles: of none where they store their stress; else of the materials of a scene, without what an
  /// implicit pressure or viscosity takes from these. Not collective.
  StressOfState(const ParticleSet& particles, std::span<const NamedMaterial> scene_materials);

  bool any() const { return any_; }

 private:
  friend class ParticleStress;
  bool any_ = false;
  ByMaterial shear_, half_bulk_;  // Pa
};

/// The Kirchhoff stress of particles, Pa, without parts by implicit pressure or viscosity. Both arguments must outlive this. Not
/// collective.
class ParticleStress {
 public:
  ParticleStress(const ParticleSet& particles, const StressOfState& of_state)
      : from_state_(of_state.any()),
        shear_(of_state.shear_, particles),
        half_bulk_(of_state.half_bulk_, particles),
        components_(particles, from_state_ ? Field::left_cauchy_green : Field::kirchhoff_stress),
        ratio_(particles, Field::volume_ratio) {}

  /// Of n_lanes particles from `p` on.
  SymTensor<Pack> of(LocalIndex p) const {
    const SymTensor<Pack> components = stored(p);
    return from_state_ ? elastic(components, shear_(p), mean(p)) : components;
  }
  /// Likewise, a third of the trace.
  Pack mean(LocalIndex p) const {
    if (from_state_) return volumetric(half_bulk_(p), ratio_(p));
    return (1.0 / 3.0) * ((components_(p, 0) + components_(p, 1)) + components_(p, 2));
  }
  /// Of n_lanes particles with another mean stress.
  SymTensor<Pack> with_mean(LocalIndex p, Pack other) const {
    SymTensor<Pack> stress = stored(p);
    if (from_state_) return elastic(stress, shear_(p), other);
    const Pack change = other - mean(p);
    for (int a = 0; a < 3; ++a) stress.c[a] += change;
    return stress;
  }
  /// Of one particle.
  SymTensor<double> of_one(LocalIndex p) const;

  /// What `of` or `with_mean`, and what `mean` reads.
  void prefetch(LocalIndex p) const {
    components_.prefetch(p);
    if (from_state_) ratio_.prefetch(p);
  }
  void prefetch_mean(LocalIndex p) const {
    if (from_state_)
      ratio_.prefetch(p);
    else
      components_.prefetch(p);
  }

 private:
  template <class Real>
  static Real volumetric(Real half_bulk, Real J) {
    return half_bulk * ((J - 1.0) * (J + 1.0));
  }
  template <class Real>
  static SymTensor<Real> elastic(const SymTensor<Real>& b, Real shear, Real mean) {
    SymTensor<Real> stress = deviator(b);
    for (Real& component : stress.c) component *= shear;
    for (int a = 0; a < 3; ++a) stress.c[a] += mean;
    return stress;
  }
  SymTensor<Pack> stored(LocalIndex p) const {
    SymTensor<Pack> components;
    for (int c = 0; c < 6; ++c) components.c[c] = components_(p, c);
    return components;
  }

  bool from_state_;
  MaterialColumn shear_, half_bulk_;
  FieldColumns<6> components_;  // of b, or of the stress
  FieldColumns<1> ratio_;
};

}  // namespace bulkley
