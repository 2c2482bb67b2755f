#pragma once
// Where a solid can touch an obstacle that is given by its signed distance.

#include <optional>
#include <vector>

#include "geometry/rigid_motion.hpp"

namespace bulkley {

/// A point of a surface; or a ball, or a rim, whose nearest point to an obstacle follows from the obstacle's normal, so that round
/// bodies roll instead of tumbling from corner to corner.
struct ContactPoint {
  Vec3 place;           ///< m
  double radius = 0.0;  ///< m, of the ball about `place`, or of the rim about `axis`
  /// Unit or 0. With a radius: of the rim. Without: the point counts for obstacles on this side only.
  Vec3 axis = Vec3::Zero();
};

/// Points of the surface no farther apart than about `spacing`, m, or than 4096 of them allow; balls for spheres and capsules, rims and
/// the edges of their ends for cylinders. Not collective, as all here.
std::vector<ContactPoint> contact_points(const Shape& shape, double spacing);
ContactPoint moved(const ContactPoint& point, const Pose& pose);

/// The place that comes nearest to an obstacle; none if the point does not face it. `normal_at(x)`: the obstacle's outward normal.
std::optional<Vec3> nearest_place(const ContactPoint& point, const auto& normal_at) {
  constexpr double facing = 0.5, upright = 0.1;
  const bool has_axis = !point.axis.isZero(0.0);
  if (!(point.radius > 0.0)) {
    if (has_axis && !(-normal_at(point.place).dot(point.axis) > facing)) return std::nullopt;
    return point.place;
  }
  Vec3 place = point.place;
  for (int pass = 0; pass < 2; ++pass) {  // the second at the surface, where sampled distances are best
    Vec3 normal = normal_at(place);
    if (has_axis) {
      normal -= normal.dot(point.axis) * point.axis;
      if (!(normal.norm() > upright)) return std::nullopt;
      normal.normalize();
    }
    place = point.place - point.radius * normal;
  }
  return place;
}

}  // namespace bulkley
