#pragma once
// A rigid body and the nodes that it holds, as one (docs/theory.md, "Rigid bodies").

#include <optional>

#include "bulkley/base/types.hpp"

namespace bulkley {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// (T-R1) of a body in a step of dt. Velocities are U = (V, length w), m/s, impulses (P, L / length), kg m/s.
struct MergedBody {
  double length = 1.0;          ///< m
  Mat6 shared, all;             ///< kg, sum of m J^T N J over the nodes; with the body itself and its spring
  Vec6 given;                   ///< sum of m J^T N v over the nodes
  Vec6 own, pull;               ///< of the body after gravity, force and torque; of its spring where it is
  std::optional<Vec6> freedom;  ///< of a guided body: U at 1 rad/s or 1 m/s
  double winding = 0.0;         ///< N m s/rad, dt times the stiffness of a spring on the turn
  double wound = 0.0;           ///< rad, turn at the start of the step
  double dt = 0.0;              ///< s; of a guided body

  /// Of a guided body's freedom after the step, rad/s or m/s. Not collective.
  double rate() const;
  /// U of body and nodes after the step. Not collective.
  Vec6 velocity() const;
  /// What further impulses on the nodes would add to it. Not collective.
  Vec6 response(const Vec6& impulse) const;
};

}  // namespace bulkley
