#pragma once
// How a free rigid body moves between contacts (docs/theory.md, "Rigid bodies"): implicit midpoint with Cayley's map, the spatial
// angular momentum being the state, so that a free top keeps momentum and energy to rounding at any step.

#include <Eigen/Geometry>

#include "bulkley/base/types.hpp"
#include "geometry/rigid_motion.hpp"

namespace bulkley {

/// What a body is, whatever it does.
struct RigidMass {
  double mass = 0.0;            ///< kg
  Vec3 moments = Vec3::Zero();  ///< kg m^2, principal
};

/// Where a body is and how it moves.
struct RigidState {
  Vec3 center = Vec3::Zero();                                    ///< m, of mass
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< of the principal frame: body to world
  Vec3 momentum = Vec3::Zero();                                  ///< kg m/s
  Vec3 angular_momentum = Vec3::Zero();                          ///< kg m^2/s, about `center`, in the frame of the world
};

/// About the centre of mass, in the frame of the world, kg m^2. Not collective.
Mat3 world_inertia(const RigidMass& mass, const RigidState& state);
/// Not collective.
RigidVelocity velocity(const RigidMass& mass, const RigidState& state);
/// J. Not collective.
double kinetic_energy(const RigidMass& mass, const RigidState& state);
/// Moves the body through `dt`, s, its momenta unchanged (R1, R2). Not collective.
void advance(const RigidMass& mass, double dt, RigidState& state);

}  // namespace bulkley
