#pragma once
// Shapes by their signed distance: negative inside, positive outside.

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "geometry/triangle_mesh.hpp"

namespace bulkley {

struct Box {
  Vec3 lower, upper;  ///< m
};
struct Sphere {
  Vec3 center;    ///< m
  double radius;  ///< m
};
/// Right circular cylinder with flat ends at `start` and `end`.
struct Cylinder {
  Vec3 start, end;  ///< m
  double radius;    ///< m
};
/// All points within `radius` of the segment from `start` to `end`.
struct Capsule {
  Vec3 start, end;  ///< m
  double radius;    ///< m
};
/// An ellipsoid with its axes along x, y, z.
struct Ellipsoid {
  Vec3 center;  ///< m
  Vec3 radii;   ///< m, half axes
};
/// The half-space { x : (x - point) . normal <= 0 }; a collider only.
struct Plane {
  Vec3 point;   ///< m
  Vec3 normal;  ///< any length > 0, points out of the solid
};

class MeshSolid;
class SampledDistance;
enum class Axis { x, y, z };
/// What a triangle mesh from a file encloses. Until it is filled (mesh_shape.hpp) it is an empty set.
struct Mesh {
  std::string file;            ///< a path, or "builtin:NAME" for a figure of builtin_mesh.hpp
  Axis up = Axis::z;           ///< the axis of the file that becomes z: y by a quarter turn about x, x by one about y
  double scale = 1.0;          ///< m per unit of the file
  std::optional<double> size;  ///< m, largest side of the bounds; replaces `scale`
  std::optional<Vec3> center;  ///< m, where the centre of the bounds goes; not moved without it
  std::string place;           ///< "file:line:column" in the scene, for messages
  WeldCount welded;            ///< what reading the file merged and dropped
  std::shared_ptr<const MeshSolid> solid;
  std::shared_ptr<const SampledDistance> sampled;  ///< replaces the distance to `solid` where there is one
};

struct Shape;

/// Everything that is in one of the parts.
struct Union {
  std::vector<Shape> parts;
};
/// Everything outside all of the parts: a pipe is what is not in its bore. A collider only.
struct Complement {
  Union inside;
};
/// The first of the parts without the others.
struct Difference {
  std::vector<Shape> parts;
};
/// `part` rotated by `angle` about `axis` through `origin`, then moved by `translation`.
struct Placed {
  std::shared_ptr<const Shape> part;
  Vec3 axis = Vec3::UnitZ();
  double angle = 0.0;  ///< rad
  Vec3 origin = Vec3::Zero();
  Vec3 translation = Vec3::Zero();  ///< m
};

struct Shape {
  std::variant<Box, Sphere, Cylinder, Capsule, Ellipsoid, Plane, Mesh, Union, Difference, Complement, Placed> kind;
};

struct Bounds {
  Vec3 lower, upper;  ///< m; infinite for a plane or a complement, lower > upper for nothing
  Vec3 center() const { return 0.5 * (lower + upper); }
};

/// Signed distance from `point` to the surface, m, negative inside. Exact for the primitives; inside a union a lower
/// bound of the depth, near a difference a lower bound on both sides, likewise outside a complement of several parts. Not
/// collective, as all functions here.
double signed_distance(const Shape& shape, const Vec3& point);
/// As signed_distance where that is at most `reach` from 0; farther away some number as far from 0, of the right sign.
double signed_distance_within(const Shape& shape, const Vec3& point, double reach);
/// Whether the point is inside: the sign of the distance, which may be cheaper than the distance.
bool contains(const Shape& shape, const Vec3& point);
/// Outward unit normal at `point`: the gradient of the signed distance (any unit vector where it is not unique).
Vec3 outward_normal(const Shape& shape, const Vec3& point);
/// Smallest axis-aligned box that holds the shape (for placed parts and differences: one that holds it).
Bounds bounds(const Shape& shape);
/// Throws UsageError "<owner>: ..." if the shape, or a part of it, encloses nothing or has a length that is not finite.
void check_shape(const Shape& shape, const std::string& owner);

}  // namespace bulkley
