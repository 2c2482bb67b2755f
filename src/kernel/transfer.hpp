#pragma once
// Which particle-grid transfer the run uses.

#include "grid/grid_geometry.hpp"

namespace bulkley {

enum class TransferScheme { pic, flip, blend, apic };

/// How the velocity gradient and the internal forces are formed (docs/theory.md, "Forces"); the two always match.
enum class GradientForm {
  mls,      ///< L_p = C_p = B_p D_p^-1; f_i = -sum V tau D_p^-1 w (x_i - x_p)   (Hu et al. 2018)
  bspline,  ///< L_p = sum v_i grad(w)^T; f_i = -sum V tau grad(w)
};

struct TransferSettings {
  TransferScheme scheme = TransferScheme::apic;
  SplineOrder order = SplineOrder::quadratic;
  GradientForm gradient = GradientForm::mls;
  double flip_ratio = 0.95;     ///< alpha of the blend: v_p = (1 - alpha) v_pic + alpha v_flip
  double affine_damping = 0.0;  ///< zeta in [0, 1]: C <- (1 - zeta) C + zeta skew(C); APIC only

  /// alpha in effect: 0 for PIC and APIC, 1 for FLIP.
  double flip_fraction() const {
    if (scheme == TransferScheme::flip) return 1.0;
    return scheme == TransferScheme::blend ? flip_ratio : 0.0;
  }
  /// Exchanges of nodes in a step: one of momenta; a FLIP part needs the changes of velocity, too.
  int n_exchanges() const { return flip_fraction() > 0.0 ? 2 : 1; }
  bool affine() const { return scheme == TransferScheme::apic; }
  /// L_p cannot be read off the stored affine matrix.
  bool needs_velocity_gradient() const { return gradient == GradientForm::bspline || (affine() && affine_damping > 0.0); }
};

}  // namespace bulkley
