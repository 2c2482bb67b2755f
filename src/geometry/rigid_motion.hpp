#pragma once
// Prescribed rigid motion of an obstacle: constant velocities, or key frames with smooth interpolation.

#include <vector>

#include "bulkley/base/types.hpp"
#include "geometry/shape.hpp"

namespace bulkley {

/// Where a rigid body is: what is at X in the scene file is at rotation * X + translation.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  ///< m

  Vec3 to_world(const Vec3& in_shape) const { return rotation * in_shape + translation; }
  Vec3 to_shape(const Vec3& in_world) const { return rotation.transpose() * (in_world - translation); }
};

/// Velocity of a rigid body: that of a point x is velocity + angular_velocity x (x - center).
struct RigidVelocity {
  Vec3 velocity = Vec3::Zero();          ///< of `center`, m/s
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s
  Vec3 center = Vec3::Zero();            ///< m

  Vec3 at(const Vec3& point) const;
};

/// A place on the way of a body, relative to where the scene file puts it.
struct KeyFrame {
  double time = 0.0;                     ///< s
  Vec3 translation = Vec3::Zero();       ///< m, of the motion's centre
  Vec3 rotation_degrees = Vec3::Zero();  ///< along the axis, about the motion's centre; more than one turn counts
};

/// Either steady velocities or, where there are any, key frames. Between key frames each component of translation and
/// rotation vector follows a piecewise cubic with a continuous velocity that goes through all key frames and overshoots none
/// (Fritsch & Carlson 1980, with the slopes of Fritsch & Butland 1984); before the first and after the last key frame the
/// body rests.
struct RigidMotion {
  Vec3 velocity = Vec3::Zero();          ///< m/s, of `center`
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, about `center`, which moves along
  Vec3 center = Vec3::Zero();            ///< m, at time 0 or where the key frames' translation is zero
  std::vector<KeyFrame> key_frames;      ///< in the order of time

  /// Whether it ever moves or is elsewhere than in the scene file.
  bool moves() const;
  Pose pose(double time) const;
  RigidVelocity velocity_at(double time) const;
  /// No point within `reach` (m) of the centre is faster than this between the times `first` and `last`, m/s.
  double speed_bound(double first, double last, double reach) const;
};

/// Signed distance and outward normal of a shape that has been moved. Not collective.
double signed_distance(const Shape& shape, const Pose& pose, const Vec3& point);
Vec3 outward_normal(const Shape& shape, const Pose& pose, const Vec3& point);
/// A box that holds the moved shape; infinite for a plane or a complement. Not collective.
Bounds bounds(const Shape& shape, const Pose& pose);

}  // namespace bulkley
