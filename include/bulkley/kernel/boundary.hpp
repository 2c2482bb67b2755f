#pragma once
// Walls and static colliders: velocity constraints on grid nodes (docs/theory.md, "Boundaries").

#include <array>
#include <string>
#include <vector>

#include "bulkley/base/tile.hpp"
#include "bulkley/particle/motion.hpp"

namespace bulkley {

enum class Contact {
  sticky,      ///< v = 0
  slip,        ///< no normal velocity in either direction, no friction
  separating,  ///< no normal velocity into the wall; Coulomb friction while pressed against it
};

enum class FaceKind { sticky, slip, separating, periodic, outflow, open };

/// One face of the domain, an entry of [boundaries].
struct Face {
  FaceKind kind = FaceKind::sticky;
  double friction = 0.0;         ///< Coulomb coefficient, separating only
  Vec3 velocity = Vec3::Zero();  ///< m/s, along the face, sticky only
};

/// Faces in the order x lower, x upper, y lower, y upper, z lower, z upper.
using Faces = std::array<Face, 6>;

/// A rigid obstacle, an entry of [[colliders]].
struct Collider {
  std::string name;
  Shape shape;
  Contact contact = Contact::sticky;
  double friction = 0.0;  ///< Coulomb coefficient, separating only
  Motion motion;          ///< prescribed; none by default
};

/// One constraint on one node. Constraints on a node are applied in the order of the list.
struct NodeConstraint {
  LocalIndex node;  ///< index into the caller's node array
  Contact contact;
  double friction;
  Vec3 normal;                   ///< out of the wall, into the material; unit
  Vec3 velocity = Vec3::Zero();  ///< of the wall, m/s
};

/// A node one cell behind a sticky or slip face, and the node one cell in front of it. In the frame of the wall the velocity
/// behind is that in front times `sign`, component by component: -1 where the wall holds it to zero, 1 where it slips.
struct NodeImage {
  LocalIndex behind, front;  ///< indices into the caller's node array
  Vec3 sign;
  Vec3 velocity;  ///< of the wall, m/s
};

/// The constraints of all nodes with signed distance <= 0 to a wall or separating collider, or <= 3/4 of a cell to a sticky
/// or slip collider. `nodes[n]`: grid indices of the caller's n-th node. Faces first, then colliders, in their order; a node
/// under several constraints gets the list twice, so that corners are consistent. Not collective.
std::vector<NodeConstraint> node_constraints(const GridGeometry& grid, const Faces& faces,
                                             const std::vector<Collider>& colliders, const std::vector<Int3>& nodes);

/// The nodes one cell behind the sticky and slip faces, axis after axis, as far as their images are among `nodes`: a
/// particle that reaches the one reaches the other. Not collective.
std::vector<NodeImage> node_images(const GridGeometry& grid, const Faces& faces, const std::vector<Int3>& nodes);

/// v -> v after contact: sticky, slip, or separating with Coulomb friction (Stomakhin et al. 2013). Not collective.
Vec3 constrained_velocity(const NodeConstraint& constraint, const Vec3& velocity);

}  // namespace bulkley
