#pragma once
// How a free rigid body moves between contacts (docs/theory.md, "Rigid bodies"): implicit midpoint with Cayley's map, the spatial
// angular momentum being the state, so that a free top keeps momentum and energy to rounding at any step.

#include <Eigen/Geometry>
#include <optional>

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
  double turn = 0.0;                                             ///< rad, about the axis of a guide since the start
};

/// What leaves a body one freedom: to turn about a fixed axis through `point`, or, without that, to move along `direction` without
/// turning.
struct Guide {
  Vec3 direction = Vec3::UnitZ();  ///< unit
  std::optional<Vec3> point;       ///< m
};

/// About the centre of mass, in the frame of the world, kg m^2. Not collective.
Mat3 world_inertia(const RigidMass& mass, const RigidState& state);
/// Not collective.
RigidVelocity velocity(const RigidMass& mass, const RigidState& state);
/// J. Not collective.
double kinetic_energy(const RigidMass& mass, const RigidState& state);
/// The velocity of a guided body whose freedom runs at 1 rad/s or 1 m/s. Not collective.
RigidVelocity unit_velocity(const Guide& guide, const RigidState& state);
/// Gives a guided body the momenta of the freedom's velocity `rate`, rad/s or m/s. Not collective.
void set_rate(const RigidMass& mass, const Guide& guide, double rate, RigidState& state);
/// Of the momenta, what the guide leaves: the rate that they give the freedom, rad/s or m/s. Not collective.
double rate_of(const RigidMass& mass, const Guide& guide, const RigidState& state);

/// Moves the body through `dt`, s: a free one with unchanged momenta (R1, R2), a guided one with an unchanged rate, exactly. Not
/// collective.
void advance(const RigidMass& mass, const std::optional<Guide>& guide, double dt, RigidState& state);

}  // namespace bulkley
