#pragma once
// Volume, centre and inertia of solids: by formula, and of closed meshes by the divergence theorem.

#include <array>
#include <optional>
#include <string>

#include "bulkley/base/types.hpp"
#include "geometry/shape.hpp"

namespace bulkley {

/// Of a solid of density 1.
struct MassProperties {
  double volume = 0.0;          ///< m^3
  Vec3 center = Vec3::Zero();   ///< m, of mass
  Mat3 inertia = Mat3::Zero();  ///< m^5, about `center`: integral of |r|^2 1 - r r^T
};

/// Of what a closed surface encloses, its triangles counter-clockwise from outside: exact sums over tetrahedra from a point near the
/// surface. A surface turned inside out has a negative volume. Not collective.
MassProperties mass_properties(const TriangleMesh& mesh);
/// None for a plane, a complement, a union, a difference and a mesh that is not filled yet: their volume is not known by formula.
/// Not collective.
std::optional<MassProperties> mass_properties(const Shape& shape);

/// The principal axes of an inertia, columns of a rotation, and the moments about them in ascending order.
struct PrincipalFrame {
  Mat3 axes = Mat3::Identity();
  Vec3 moments = Vec3::Zero();
};
/// Not collective.
PrincipalFrame principal_frame(const Mat3& inertia);
/// Whether some body can have these ascending moments: all positive, and none greater than the sum of the others, up to rounding. Not
/// collective.
bool are_moments(const Vec3& moments);

}  // namespace bulkley
