#pragma once
// Which particle-grid transfer the run uses.

#include "grid/grid_geometry.hpp"
#include "kernel/step_bounds.hpp"

namespace bulkley {

enum class TransferScheme { pic, flip, blend, apic, moment_flip };

/// How the velocity gradient and the internal forces are formed (docs/theory.md, "Forces"); the two always match.
enum class GradientForm {
  mls,      ///< L_p = C_p = B_p D_p^-1; f_i = -sum V tau D_p^-1 w (x_i - x_p)   (Hu et al. 2018)
  bspline,  ///< L_p = sum v_i grad(w)^T; f_i = -sum V tau grad(w)
};

/// Whose volume a material with a volumetric law keeps in the explicit step (docs/theory.md, "Dilation by cells").
enum class Dilation {
  automatic,  ///< by cell if the material flows, by particle if it is an elastic solid
  particle,   ///< that of each particle by itself
  cell,       ///< that of its particles in a cell together
};

struct TransferSettings {
  TransferScheme scheme = TransferScheme::moment_flip;
  SplineOrder order = SplineOrder::quadratic;
  GradientForm gradient = GradientForm::mls;
  Dilation dilation = Dilation::automatic;
  bool close_voids = true;         ///< fluids fill what fronts leave empty at floors (docs/theory.md, (V6))
  bool thin_layers = true;         ///< fluids with a yield stress shear on sticky floors in layers thinner than a cell (T13f)
  double flip_ratio = 0.95;        ///< alpha of the blend: v_p = (1 - alpha) v_pic + alpha v_flip
  double damping_time = 0.0;       ///< s; the residual decays in it (blend, moment_flip). 0: by flip_ratio; by the two below
  double damping_strain = 1.0;     ///< moment_flip: strain of the fastest deforming particle in which the residual decays
  double damping_distance = 10.0;  ///< moment_flip: cells that a shear wave crosses while the residual decays
  double affine_damping = 0.0;     ///< zeta in [0, 1]: C <- (1 - zeta) C + zeta skew(C); APIC only

  /// Whether particles keep a part of what the grid does not see of their motion. That needs the change of the nodes' velocities.
  bool keeps_residual() const {
    return scheme == TransferScheme::flip || scheme == TransferScheme::moment_flip ||
           (scheme == TransferScheme::blend && (flip_ratio > 0.0 || damping_time > 0.0));
  }
  /// The rate at which the residual decays, 1/s: 1 / damping_time; or, of moment_flip, the largest ||L_p|| over damping_strain
  /// and the rate at which shear waves and viscosity cross a cell over damping_distance. `shear_wave_speed`: the largest of
  /// the materials at rest, m/s. The same on every rank, for `motion` is. Not collective.
  double decay_rate(double cell_size, const MotionBounds& motion, double shear_wave_speed) const;
  /// The part of the residual that is kept over a step of dt (s) when it decays at `rate` (1/s): 0 for PIC and APIC, 1 for
  /// FLIP, flip_ratio of a blend without a damping time. Not collective.
  double kept_share(double dt, double rate) const;
  /// Exchanges of nodes in a step: one of momenta; a residual needs the changes of velocity, too.
  int n_exchanges() const { return keeps_residual() ? 2 : 1; }
  bool affine() const { return scheme == TransferScheme::apic || scheme == TransferScheme::moment_flip; }
  /// L_p cannot be read off the stored affine matrix.
  bool needs_velocity_gradient() const {
    return gradient == GradientForm::bspline || scheme == TransferScheme::moment_flip ||
           (scheme == TransferScheme::apic && affine_damping > 0.0);
  }
};

/// D of the kinetic energy (m / 2)(|v|^2 + D |C|^2) of a particle, m^2; 0 for transfers without an affine part. Not
/// collective.
double affine_inertia(const GridGeometry& grid, const TransferSettings& transfer);

}  // namespace bulkley
