#pragma once
// What a triangle mesh encloses, holes or not: the nearest point of its surface, and the winding number for inside and
// outside.

#include <limits>
#include <vector>

#include "geometry/triangle_mesh.hpp"

namespace bulkley {

/// The set of points within the bounds whose winding number exceeds 1/2, of a mesh in any state: with holes, with triangles
/// missing, with parts that intersect. Where the mesh has a hole, the surface of winding number 1/2 closes it. A closed mesh
/// has 1 inside and 0 outside. The same bits on every rank: one order of triangles, one order of sums.
class MeshSolid {
 public:
  /// `mesh`: welded, with at least one triangle.
  explicit MeshSolid(TriangleMesh mesh);

  const TriangleMesh& mesh() const { return mesh_; }
  const MeshFacts& facts() const { return facts_; }

  /// Generalised winding number (Jacobson et al. 2013), turned positive for a mesh that faces inwards; clusters of triangles
  /// that are far away count as dipoles (Barill et al. 2018), which makes it wrong by up to some 0.04. Not collective, as
  /// all functions here.
  double winding_number(const Vec3& x) const;
  bool contains(const Vec3& x) const;

  struct Nearest {
    Vec3 point;
    double distance;  ///< m
    int triangle;     ///< in the order of this object's own
  };
  /// The nearest point of the triangles; if none is within `reach`, only the distance is set, to `reach`.
  Nearest nearest(const Vec3& x, double reach = std::numeric_limits<double>::infinity()) const;

  /// Negative inside. The distance to the nearest triangle; near a hole a lower bound of the distance to what closes it,
  /// too, so that it goes through zero there: within the hole's rim the distance to triangles alone would jump.
  /// Beyond `reach` it is some number as far from 0, of the right sign.
  double signed_distance(const Vec3& x, double reach = std::numeric_limits<double>::infinity()) const;
  /// Outward unit normal: along the way to the nearest point, that of the triangle on the surface itself.
  Vec3 outward_normal(const Vec3& x) const;

 private:
  struct Triangle {
    Vec3 a, b, c;
  };
  /// A box of triangles, and their winding number at a distance.
  struct Node {
    Vec3 lower, upper;
    Vec3 center;          ///< of area
    Vec3 area;            ///< sum of the triangles' area vectors, m^2
    double near_squared;  ///< m^2; closer than this the triangles are no dipole
    int first;            ///< triangle of a leaf; else the second child, the first one being the next node
    int count;            ///< triangles of a leaf; else 0
  };

  int build(std::vector<int>& order, int first, int last);
  void summarise(Node& node, int first, int last) const;
  double distance_to_bounds(const Vec3& x) const;

  TriangleMesh mesh_;
  MeshFacts facts_;
  double sense_;  ///< -1 for a mesh that faces inwards
  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace bulkley
