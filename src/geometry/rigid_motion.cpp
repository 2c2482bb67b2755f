#include "geometry/rigid_motion.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace bulkley {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180.0;

/// A component of a key frame: 0 to 2 of the translation in m, 3 to 5 of the rotation in radians.
double component(const KeyFrame& key, int c) {
  return c < 3 ? key.translation[c] : radians_per_degree * key.rotation_degrees[c - 3];
}

/// Mean rate of change in the segment that begins at key frame k.
double secant(const std::vector<KeyFrame>& keys, std::size_t k, int c) {
  return (component(keys[k + 1], c) - component(keys[k], c)) / (keys[k + 1].time - keys[k].time);
}

/// Rate of change at key frame k: zero at the ends and where the direction changes, else the weighted harmonic mean of the
/// secants, which keeps the cubic monotone.
double slope(const std::vector<KeyFrame>& keys, std::size_t k, int c) {
  if (k == 0 || k + 1 == keys.size()) return 0.0;
  const double before = secant(keys, k - 1, c), after = secant(keys, k, c);
  if (before * after <= 0.0) return 0.0;
  const double h_before = keys[k].time - keys[k - 1].time, h_after = keys[k + 1].time - keys[k].time;
  const double w_before = h_before + 2.0 * h_after, w_after = 2.0 * h_before + h_after;
  return (w_before + w_after) / (w_before / before + w_after / after);
}

/// One component and its rate within a segment: Hermite's cubic.
struct Cubic {
  double h, start, end, start_slope, end_slope;

  double value(double s) const {
    const double r = 1.0 - s;
    return (1.0 + 2.0 * s) * r * r * start + s * r * r * h * start_slope + s * s * (3.0 - 2.0 * s) * end -
           s * s * r * h * end_slope;
  }
  double rate(double s) const {
    const double mean = (end - start) / h;
    return 6.0 * s * (1.0 - s) * mean + (1.0 - s) * (1.0 - 3.0 * s) * start_slope + s * (3.0 * s - 2.0) * end_slope;
  }
  /// Largest |rate| in the segment: at an end or where the quadratic turns.
  double largest_rate() const {
    const double mean = (end - start) / h;
    const double a = 3.0 * (start_slope + end_slope) - 6.0 * mean, b = 6.0 * mean - 4.0 * start_slope - 2.0 * end_slope;
    double largest = std::max(std::abs(start_slope), std::abs(end_slope));
    const double turn = a != 0.0 ? -0.5 * b / a : -1.0;
    if (turn > 0.0 && turn < 1.0) largest = std::max(largest, std::abs(rate(turn)));
    return largest;
  }
};

Cubic cubic(const std::vector<KeyFrame>& keys, std::size_t k, int c) {
  return {keys[k + 1].time - keys[k].time, component(keys[k], c), component(keys[k + 1], c), slope(keys, k, c),
          slope(keys, k + 1, c)};
}

/// Translation and rotation vector with their rates.
struct Place {
  std::array<double, 6> value{}, rate{};
};

Place place_at(const std::vector<KeyFrame>& keys, double time) {
  Place place;
  if (time <= keys.front().time || time >= keys.back().time) {
    const KeyFrame& end = time <= keys.front().time ? keys.front() : keys.back();
    for (int c = 0; c < 6; ++c) place.value[static_cast<std::size_t>(c)] = component(end, c);
    return place;
  }
  std::size_t k = 0;
  while (keys[k + 1].time <= time) ++k;
  const double s = (time - keys[k].time) / (keys[k + 1].time - keys[k].time);
  for (int c = 0; c < 6; ++c) {
    const Cubic curve = cubic(keys, k, c);
    place.value[static_cast<std::size_t>(c)] = curve.value(s);
    place.rate[static_cast<std::size_t>(c)] = curve.rate(s);
  }
  return place;
}

Mat3 rotation_of(const Vec3& vector) {
  const double angle = vector.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix() : Mat3(Mat3::Identity());
}

/// Angular velocity of exp(theta(t)) with d theta / dt = rate: the left Jacobian of the rotation group.
Vec3 angular_velocity_of(const Vec3& theta, const Vec3& rate) {
  const double angle = theta.norm(), square = angle * angle;
  const bool small = angle < 1e-4;
  const double a = small ? 0.5 - square / 24.0 : (1.0 - std::cos(angle)) / square;
  const double b = small ? 1.0 / 6.0 - square / 120.0 : (angle - std::sin(angle)) / (square * angle);
  const Vec3 turned = theta.cross(rate);
  return rate + a * turned + b * theta.cross(turned);
}

}  // namespace

Vec3 RigidVelocity::at(const Vec3& point) const { return velocity + angular_velocity.cross(point - center); }

bool RigidMotion::moves() const {
  for (const KeyFrame& key : key_frames)
    if (!key.translation.isZero(0.0) || !key.rotation_degrees.isZero(0.0)) return true;
  return key_frames.empty() && !(velocity.isZero(0.0) && angular_velocity.isZero(0.0));
}

Pose RigidMotion::pose(double time) const {
  Vec3 shift = time * velocity, turn = time * angular_velocity;
  if (!key_frames.empty()) {
    const Place place = place_at(key_frames, time);
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      shift[a] = place.value[axis];
      turn[a] = place.value[3 + axis];
    }
  }
  const Mat3 rotation = rotation_of(turn);
  return {rotation, center + shift - rotation * center};
}

RigidVelocity RigidMotion::velocity_at(double time) const {
  if (key_frames.empty()) return {velocity, angular_velocity, center + time * velocity};
  const Place place = place_at(key_frames, time);
  const auto& x = place.value;
  const auto& v = place.rate;
  return {Vec3(v[0], v[1], v[2]), angular_velocity_of(Vec3(x[3], x[4], x[5]), Vec3(v[3], v[4], v[5])),
          center + Vec3(x[0], x[1], x[2])};
}

double RigidMotion::speed_bound(double first, double last, double reach) const {
  if (key_frames.empty()) return velocity.norm() + (angular_velocity.isZero(0.0) ? 0.0 : angular_velocity.norm() * reach);
  double largest = 0.0;
  for (std::size_t k = 0; k + 1 < key_frames.size(); ++k) {
    if (key_frames[k + 1].time < first || key_frames[k].time > last) continue;
    Vec3 shift, turn;
    for (int a = 0; a < 3; ++a) {
      shift[a] = cubic(key_frames, k, a).largest_rate();
      turn[a] = cubic(key_frames, k, 3 + a).largest_rate();
    }
    // The left Jacobian does not lengthen.
    largest = std::max(largest, shift.norm() + (turn.isZero(0.0) ? 0.0 : turn.norm() * reach));
  }
  return largest;
}

double signed_distance(const Shape& shape, const Pose& pose, const Vec3& point) {
  return signed_distance(shape, pose.to_shape(point));
}

Vec3 outward_normal(const Shape& shape, const Pose& pose, const Vec3& point) {
  return pose.rotation * outward_normal(shape, pose.to_shape(point));
}

Bounds bounds(const Shape& shape, const Pose& pose) {
  Bounds b = bounds(shape);
  if (!b.lower.allFinite() || !b.upper.allFinite()) return b;
  const Vec3 center = pose.to_world(b.center());
  const Vec3 reach = pose.rotation.cwiseAbs() * (0.5 * (b.upper - b.lower));
  return {center - reach, center + reach};
}

}  // namespace bulkley
