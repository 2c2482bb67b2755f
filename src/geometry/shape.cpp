#include "geometry/shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_solid.hpp"
#include "geometry/sampled_distance.hpp"

namespace bulkley {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// `v` / |v|, or `otherwise` where v vanishes.
Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length = v.norm();
  return length > 0.0 ? Vec3(v / length) : otherwise;
}

/// Any unit vector at right angles to the unit vector `axis`.
Vec3 perpendicular(const Vec3& axis) {
  int smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  return axis.cross(Vec3::Unit(smallest)).normalized();
}

// --- box -------------------------------------------------------------------------------------------------------------

/// Signed distance along each axis to the nearer of the two faces, negative between them.
Vec3 face_distances(const Box& box, const Vec3& x) { return (box.lower - x).cwiseMax(x - box.upper); }

double distance(const Box& box, const Vec3& x) {
  const Vec3 q = face_distances(box, x);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

Vec3 normal(const Box& box, const Vec3& x) {
  const Vec3 q = face_distances(box, x);
  const Vec3 middle = 0.5 * (box.lower + box.upper);
  Vec3 outside = Vec3::Zero();
  for (int a = 0; a < 3; ++a) outside[a] = std::copysign(std::max(q[a], 0.0), x[a] - middle[a]);
  int nearest = 0;
  q.maxCoeff(&nearest);
  const Vec3 face = Vec3::Unit(nearest) * std::copysign(1.0, x[nearest] - middle[nearest]);
  return unit_or(outside, face);
}

Bounds extent(const Box& box) { return {box.lower, box.upper}; }

// --- sphere ----------------------------------------------------------------------------------------------------------

double distance(const Sphere& sphere, const Vec3& x) { return (x - sphere.center).norm() - sphere.radius; }
Vec3 normal(const Sphere& sphere, const Vec3& x) { return unit_or(x - sphere.center, Vec3::UnitZ()); }
Bounds extent(const Sphere& sphere) {
  return {sphere.center.array() - sphere.radius, sphere.center.array() + sphere.radius};
}

// --- cylinder --------------------------------------------------------------------------------------------------------

/// A point in the cylinder's own coordinates.
struct CylinderCoordinates {
  Vec3 axis;      ///< unit, from start to end
  Vec3 radial;    ///< unit, away from the axis
  double beside;  ///< signed distance to the mantle, m
  double beyond;  ///< signed distance to the nearer end, m
  double side;    ///< -1: that is the start, +1: the end
};

CylinderCoordinates coordinates(const Cylinder& cylinder, const Vec3& x) {
  const Vec3 along = cylinder.end - cylinder.start;
  const double length = along.norm();
  const Vec3 axis = along / length;
  const Vec3 relative = x - cylinder.start;
  const double height = relative.dot(axis);
  const Vec3 radial = relative - height * axis;
  return {axis, unit_or(radial, perpendicular(axis)), radial.norm() - cylinder.radius, std::max(-height, height - length),
          height < 0.5 * length ? -1.0 : 1.0};
}

double distance(const Cylinder& cylinder, const Vec3& x) {
  const CylinderCoordinates c = coordinates(cylinder, x);
  return std::hypot(std::max(c.beside, 0.0), std::max(c.beyond, 0.0)) + std::min(std::max(c.beside, c.beyond), 0.0);
}

Vec3 normal(const Cylinder& cylinder, const Vec3& x) {
  const CylinderCoordinates c = coordinates(cylinder, x);
  const Vec3 outside = std::max(c.beside, 0.0) * c.radial + std::max(c.beyond, 0.0) * c.side * c.axis;
  return unit_or(outside, c.beside >= c.beyond ? c.radial : Vec3(c.side * c.axis));
}

Bounds extent(const Cylinder& cylinder) {
  const Vec3 axis = (cylinder.end - cylinder.start).normalized();
  // A disc of radius R with this normal reaches R sqrt(1 - a_i^2) along axis i.
  const Vec3 reach = cylinder.radius * (1.0 - axis.array().square()).max(0.0).sqrt();
  return {cylinder.start.cwiseMin(cylinder.end) - reach, cylinder.start.cwiseMax(cylinder.end) + reach};
}

// --- capsule ---------------------------------------------------------------------------------------------------------

/// From the nearest point of the segment to x.
Vec3 from_segment(const Capsule& capsule, const Vec3& x) {
  const Vec3 along = capsule.end - capsule.start;
  const Vec3 relative = x - capsule.start;
  const double length_squared = along.squaredNorm();
  const double t = length_squared > 0.0 ? std::clamp(relative.dot(along) / length_squared, 0.0, 1.0) : 0.0;
  return relative - t * along;
}

double distance(const Capsule& capsule, const Vec3& x) { return from_segment(capsule, x).norm() - capsule.radius; }
Vec3 normal(const Capsule& capsule, const Vec3& x) {
  return unit_or(from_segment(capsule, x), perpendicular(unit_or(capsule.end - capsule.start, Vec3::UnitZ())));
}
Bounds extent(const Capsule& capsule) {
  return {capsule.start.cwiseMin(capsule.end).array() - capsule.radius,
          capsule.start.cwiseMax(capsule.end).array() + capsule.radius};
}

// --- ellipsoid ---------------------------------------------------------------------------------------------------------

/// The point of the surface that is nearest to x = centre + y, relative to the centre: r_i^2 y_i / (t + r_i^2) with the largest
/// root t of sum (r_i y_i / (t + r_i^2))^2 = 1. The sum falls and is convex: Newton's method from below never passes the root.
Vec3 nearest_on_surface(const Ellipsoid& ellipsoid, const Vec3& x) {
  const Eigen::Array3d r = ellipsoid.radii, y = (x - ellipsoid.center).array();
  // On a plane of symmetry two points may be nearest, where t is -r_min^2 exactly; just off the plane there is one.
  const Eigen::Array3d product = r * y.abs().max(1e-14 * r.minCoeff());
  const Eigen::Array3d beyond = (r - r.minCoeff()) * (r + r.minCoeff());
  double s = (product - beyond).maxCoeff();  // t + r_min^2, which keeps its digits; one term is 1 here
  for (int iteration = 0; iteration < 200; ++iteration) {
    const Eigen::Array3d term = (product / (s + beyond)).square();
    const double next = s + 0.5 * (term.sum() - 1.0) / (term / (s + beyond)).sum();
    if (!(next > s)) break;  // rounding: at the root
    s = next;
  }
  const Eigen::Array3d nearest = r * product / (s + beyond);
  return (nearest * (y < 0.0).select(-1.0, Eigen::Array3d::Ones())).matrix();
}

double distance(const Ellipsoid& ellipsoid, const Vec3& x) {
  const Vec3 y = x - ellipsoid.center;
  const double length = (nearest_on_surface(ellipsoid, x) - y).norm();
  return y.cwiseQuotient(ellipsoid.radii).squaredNorm() < 1.0 ? -length : length;
}

Vec3 normal(const Ellipsoid& ellipsoid, const Vec3& x) {
  const Eigen::Array3d r = ellipsoid.radii;
  return (nearest_on_surface(ellipsoid, x).array() / (r * r)).matrix().normalized();
}

Bounds extent(const Ellipsoid& e) { return {e.center - e.radii, e.center + e.radii}; }

// --- plane -----------------------------------------------------------------------------------------------------------

Vec3 normal(const Plane& plane, const Vec3&) { return plane.normal.normalized(); }
double distance(const Plane& plane, const Vec3& x) { return (x - plane.point).dot(normal(plane, x)); }
Bounds extent(const Plane&) { return {Vec3::Constant(-infinity), Vec3::Constant(infinity)}; }

// --- mesh ------------------------------------------------------------------------------------------------------------

double distance_within(const Mesh& mesh, const Vec3& x, double reach) {
  if (mesh.sampled) return mesh.sampled->distance(x);
  return mesh.solid ? mesh.solid->signed_distance(x, reach) : infinity;
}
double distance(const Mesh& mesh, const Vec3& x) { return distance_within(mesh, x, infinity); }
Vec3 normal(const Mesh& mesh, const Vec3& x) {
  if (mesh.sampled) return mesh.sampled->normal(x);
  return mesh.solid ? mesh.solid->outward_normal(x) : Vec3::UnitZ();
}
Bounds extent(const Mesh& mesh) {
  if (!mesh.solid) return {Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  return {mesh.solid->facts().lower, mesh.solid->facts().upper};
}

// --- union -----------------------------------------------------------------------------------------------------------

double distance(const Union& all, const Vec3& x) {
  double nearest = infinity;
  for (const Shape& part : all.parts) nearest = std::min(nearest, signed_distance(part, x));
  return nearest;
}

Vec3 normal(const Union& all, const Vec3& x) {
  const auto nearest = std::min_element(all.parts.begin(), all.parts.end(), [&](const Shape& a, const Shape& b) {
    return signed_distance(a, x) < signed_distance(b, x);
  });
  return outward_normal(*nearest, x);
}

Bounds extent(const Union& all) {
  Bounds result{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  for (const Shape& part : all.parts) {
    const Bounds b = bounds(part);
    result.lower = result.lower.cwiseMin(b.lower);
    result.upper = result.upper.cwiseMax(b.upper);
  }
  return result;
}

// --- complement ------------------------------------------------------------------------------------------------------

double distance(const Complement& complement, const Vec3& x) { return -distance(complement.inside, x); }
Vec3 normal(const Complement& complement, const Vec3& x) { return -normal(complement.inside, x); }
Bounds extent(const Complement&) { return {Vec3::Constant(-infinity), Vec3::Constant(infinity)}; }
// --- difference --------------------------------------------------------------------------------------------------------

/// The part whose surface decides at x: the first, or one of those that are taken away.
std::size_t deciding_part(const Difference& difference, const Vec3& x) {
  std::size_t deciding = 0;
  double largest = signed_distance(difference.parts[0], x);
  for (std::size_t n = 1; n < difference.parts.size(); ++n) {
    const double beside = -signed_distance(difference.parts[n], x);
    if (beside <= largest) continue;
    largest = beside;
    deciding = n;
  }
  return deciding;
}

double distance(const Difference& difference, const Vec3& x) {
  const std::size_t n = deciding_part(difference, x);
  return n == 0 ? signed_distance(difference.parts[0], x) : -signed_distance(difference.parts[n], x);
}

Vec3 normal(const Difference& difference, const Vec3& x) {
  const std::size_t n = deciding_part(difference, x);
  return n == 0 ? outward_normal(difference.parts[0], x) : Vec3(-outward_normal(difference.parts[n], x));
}

Bounds extent(const Difference& difference) { return bounds(difference.parts[0]); }

// --- placed ----------------------------------------------------------------------------------------------------------

Mat3 rotation(const Placed& placed) { return Eigen::AngleAxisd(placed.angle, placed.axis.normalized()).toRotationMatrix(); }

/// Where the point x of the placed shape was before it was placed.
Vec3 before(const Placed& placed, const Mat3& turn, const Vec3& x) {
  return turn.transpose() * (x - placed.translation - placed.origin) + placed.origin;
}

double distance(const Placed& placed, const Vec3& x) {
  return signed_distance(*placed.part, before(placed, rotation(placed), x));
}

Vec3 normal(const Placed& placed, const Vec3& x) {
  const Mat3 turn = rotation(placed);
  return turn * outward_normal(*placed.part, before(placed, turn, x));
}

Bounds extent(const Placed& placed) {
  const Bounds b = bounds(*placed.part);
  if (!b.lower.allFinite() || !b.upper.allFinite()) return {Vec3::Constant(-infinity), Vec3::Constant(infinity)};
  const Mat3 turn = rotation(placed);
  const Vec3 center = turn * (b.center() - placed.origin) + placed.origin + placed.translation;
  const Vec3 reach = turn.cwiseAbs() * (0.5 * (b.upper - b.lower));
  return {center - reach, center + reach};
}

// --- distances up to a reach -----------------------------------------------------------------------------------------

template <class Primitive>
double distance_within(const Primitive& shape, const Vec3& x, double) {
  return distance(shape, x);
}
double distance_within(const Union& all, const Vec3& x, double reach) {
  double nearest = infinity;
  for (const Shape& part : all.parts) nearest = std::min(nearest, signed_distance_within(part, x, reach));
  return nearest;
}
double distance_within(const Difference& difference, const Vec3& x, double reach) {
  double largest = signed_distance_within(difference.parts[0], x, reach);
  for (std::size_t n = 1; n < difference.parts.size(); ++n)
    largest = std::max(largest, -signed_distance_within(difference.parts[n], x, reach));
  return largest;
}
double distance_within(const Placed& placed, const Vec3& x, double reach) {
  return signed_distance_within(*placed.part, before(placed, rotation(placed), x), reach);
}

// --- inside or not ---------------------------------------------------------------------------------------------------

template <class Primitive>
bool holds(const Primitive& shape, const Vec3& x) {
  return distance(shape, x) <= 0.0;
}
bool holds(const Mesh& mesh, const Vec3& x) {
  return mesh.solid && !mesh.sampled ? mesh.solid->contains(x) : distance(mesh, x) <= 0.0;
}
bool holds(const Union& all, const Vec3& x) {
  return std::any_of(all.parts.begin(), all.parts.end(), [&](const Shape& part) { return contains(part, x); });
}
bool holds(const Difference& difference, const Vec3& x) {
  if (!contains(difference.parts[0], x)) return false;
  for (std::size_t n = 1; n < difference.parts.size(); ++n)
    if (signed_distance(difference.parts[n], x) < 0.0) return false;  // the common surface belongs to what is left
  return true;
}
bool holds(const Placed& placed, const Vec3& x) { return contains(*placed.part, before(placed, rotation(placed), x)); }

// --- checks ----------------------------------------------------------------------------------------------------------

bool is_positive(double length) { return length > 0.0 && std::isfinite(length); }

/// What is wrong with a shape; null if nothing is.
const char* fault(const Box& box) {
  if (!box.lower.allFinite() || !box.upper.allFinite()) return "a box needs finite corners";
  return (box.lower.array() < box.upper.array()).all() ? nullptr : "a box needs lower < upper along every axis";
}
const char* fault(const Sphere& sphere) {
  return sphere.center.allFinite() && is_positive(sphere.radius) ? nullptr
                                                                 : "a sphere needs a finite centre and a radius > 0";
}
const char* fault(const Cylinder& cylinder) {
  if (!is_positive((cylinder.end - cylinder.start).norm())) return "a cylinder needs two different, finite end points";
  return is_positive(cylinder.radius) ? nullptr : "a cylinder needs a radius > 0";
}
const char* fault(const Capsule& capsule) {
  if (!capsule.start.allFinite() || !capsule.end.allFinite()) return "a capsule needs finite end points";
  return is_positive(capsule.radius) ? nullptr : "a capsule needs a radius > 0";
}
const char* fault(const Ellipsoid& e) {
  return e.center.allFinite() && e.radii.allFinite() && e.radii.minCoeff() > 0.0
             ? nullptr
             : "an ellipsoid needs a finite centre and radii > 0";
}
const char* fault(const Plane& plane) {
  return plane.point.allFinite() && is_positive(plane.normal.norm())
             ? nullptr
             : "a plane needs a finite point and a normal of length > 0";
}
const char* fault(const Mesh& mesh) { return mesh.solid ? nullptr : "its mesh has not been read"; }
const char* fault(const Shape& shape);
const char* fault(const Union& all) {
  if (all.parts.empty()) return "a union needs at least one part";
  for (const Shape& part : all.parts)
    if (const char* what = fault(part)) return what;
  return nullptr;
}
const char* fault(const Complement& complement) {
  return complement.inside.parts.empty() ? "a complement needs at least one part" : fault(complement.inside);
}
const char* fault(const Difference& difference) {
  if (difference.parts.size() < 2) return "a difference needs at least two parts";
  for (const Shape& part : difference.parts)
    if (const char* what = fault(part)) return what;
  return nullptr;
}
const char* fault(const Placed& placed) {
  if (!placed.part) return "a placed shape needs a part";
  if (!is_positive(placed.axis.norm()) || !std::isfinite(placed.angle))
    return "a placed shape needs a rotation axis of length > 0 and a finite angle";
  if (!placed.origin.allFinite() || !placed.translation.allFinite())
    return "a placed shape needs a finite origin and translation";
  return fault(*placed.part);
}
const char* fault(const Shape& shape) {
  return std::visit([](const auto& kind) { return fault(kind); }, shape.kind);
}

}  // namespace

double signed_distance(const Shape& shape, const Vec3& point) {
  return std::visit([&](const auto& kind) { return distance(kind, point); }, shape.kind);
}

double signed_distance_within(const Shape& shape, const Vec3& point, double reach) {
  return std::visit([&](const auto& kind) { return distance_within(kind, point, reach); }, shape.kind);
}

bool contains(const Shape& shape, const Vec3& point) {
  return std::visit([&](const auto& kind) { return holds(kind, point); }, shape.kind);
}

Vec3 outward_normal(const Shape& shape, const Vec3& point) {
  return std::visit([&](const auto& kind) { return normal(kind, point); }, shape.kind);
}

Bounds bounds(const Shape& shape) {
  return std::visit([](const auto& kind) { return extent(kind); }, shape.kind);
}

void check_shape(const Shape& shape, const std::string& owner) {
  if (const char* what = fault(shape)) throw UsageError(owner + ": " + what);
}

}  // namespace bulkley
