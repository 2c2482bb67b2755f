#pragma once
// Surfaces of triangles: the plain data, and their properties before they become a solid.

#include <vector>

#include "bulkley/base/types.hpp"

namespace bulkley {

struct TriangleMesh {
  std::vector<Vec3> vertices;   ///< m, once placed in a scene; before that in the unit of the file
  std::vector<Int3> triangles;  ///< indices of vertices, counter-clockwise seen from outside
};

/// What `weld` changed.
struct WeldCount {
  std::size_t vertices = 0;    ///< merged into another at exactly the same place
  std::size_t degenerate = 0;  ///< triangles dropped because they have no area
  std::size_t duplicates = 0;  ///< triangles dropped because the same one comes earlier
};

/// Merges vertices at exactly equal places, and drops those without a triangle, triangles without area and repeated ones.
/// Vertices keep the order in which they first appear. Not collective, as all functions here.
WeldCount weld(TriangleMesh& mesh);

struct MeshFacts {
  Vec3 lower, upper;  ///< of the bounds
  /// By the divergence theorem, holes closed by fans from the middles of their rims; negative: the triangles face inwards.
  double volume = 0.0;
  double area = 0.0;                 ///< of all triangles
  std::size_t n_components = 0;      ///< parts that share no vertex
  std::size_t n_boundary_edges = 0;  ///< edges that more triangles run along one way than the other way
  std::size_t n_holes = 0;           ///< sets of boundary edges that hang together
  bool closed() const { return n_boundary_edges == 0; }
};

/// Facts of a welded mesh with at least one triangle.
MeshFacts facts(const TriangleMesh& mesh);

}  // namespace bulkley
