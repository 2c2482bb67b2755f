#pragma once
// Walls and rigid colliders: velocity constraints on grid nodes (docs/theory.md, "Boundaries").

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/rigid_motion.hpp"
#include "grid/face.hpp"
#include "grid/grid_geometry.hpp"

namespace bulkley {

std::string name(Contact contact);

/// A rigid obstacle, an entry of [[colliders]].
struct Collider {
  std::string name;
  Shape shape;
  Contact contact = Contact::sticky;
  double friction = 0.0;         ///< Coulomb coefficient, separating only
  RigidMotion motion{};          ///< prescribed; none by default
  std::optional<Vec3> center{};  ///< m, of the motion, where the scene gives one; see settle_center
};

/// Makes `collider.center` the centre of its motion, or else the centre of its shape's bounds where those are finite. To be
/// called again once a mesh has been read. Not collective.
void settle_center(Collider& collider);

/// Cells from face `f` (x lower, x upper, y lower, ...) to the node, positive inside the domain. Not collective.
int cells_inside(const GridGeometry& grid, int f, const Int3& node);

/// How far in front of an obstacle a node is still held, m. Not collective.
double hold_distance(const GridGeometry& grid, Contact contact);

/// One constraint on one node. Constraints on a node are applied in the order of the list.
struct NodeConstraint {
  LocalIndex node;  ///< index into the caller's node array
  Contact contact;
  double friction;
  Vec3 normal;                   ///< out of the wall, into the material; unit
  Vec3 velocity = Vec3::Zero();  ///< of the wall there, m/s
  std::int32_t collider = -1;    ///< its number in the scene; -1: a face of the domain
  Vec3 arm = Vec3::Zero();       ///< from the collider's centre to the node, m
};

/// A node one cell behind a face whose nodes behind follow their mirror images (NodesBehind), and the node one cell in front
/// of it. In the frame of the wall the velocity behind is that in front times `sign`, component by component: -1 where the
/// wall holds it to zero, 1 where it slips.
struct NodeImage {
  LocalIndex behind, front;  ///< indices into the caller's node array
  Vec3 sign;
  Vec3 velocity;           ///< of the wall, m/s
  std::int32_t face = -1;  ///< its number
};

/// A node one cell behind a face, and the one as far in front of it: indices into the caller's node array.
struct MirrorPair {
  LocalIndex behind, front;
};

/// Those of face `f` of which both are among the caller's nodes. `nodes[n]`: grid indices of the n-th. Not collective.
std::vector<MirrorPair> mirror_pairs(const GridGeometry& grid, int f, const std::vector<Int3>& nodes);

/// The constraints of all nodes with signed distance <= 0 to a wall or separating collider, or <= 3/4 of a cell to a sticky
/// or slip collider, by what does not move. `nodes[n]`: grid indices of the caller's n-th node. Faces first, then colliders,
/// in their order; a node under several constraints gets the list twice, so that corners are consistent. Not collective.
std::vector<NodeConstraint> node_constraints(const GridGeometry& grid, const Faces& faces,
                                             const std::vector<Collider>& colliders, const std::vector<Int3>& nodes);

/// The constraints by what moves, found anew for each step.
class MovingConstraints {
 public:
  /// `nodes` as for node_constraints, which gave `fixed`. `places[n]`: index of the n-th node in the array that the
  /// constraints found will be applied to. Not collective.
  MovingConstraints(const GridGeometry& grid, const std::vector<Collider>& colliders, std::vector<Int3> nodes,
                    std::vector<LocalIndex> places, std::vector<NodeConstraint> fixed);

  /// Those of the step from `time` to `time` + `dt`, to be applied after the fixed ones: colliders in their order where they
  /// are at `time`, with the velocity of the middle of the step. A node under several constraints, fixed ones included, gets
  /// all of them once more. Valid until the next call. Not collective.
  const std::vector<NodeConstraint>& at(double time, double dt);

  std::size_t memory() const;

 private:
  void add_collider(std::size_t number, double time, double dt);

  GridGeometry grid_;
  std::vector<Collider> colliders_;
  std::vector<Int3> nodes_;
  std::vector<LocalIndex> places_;
  std::vector<NodeConstraint> fixed_;     ///< by node, each once
  std::vector<NodeConstraint> touching_;  ///< of the present step, by collider and node
  std::vector<NodeConstraint> result_;
};

/// Speed that no point of a collider exceeds inside the domain between two times, m/s. Not collective.
double collider_speed(const GridGeometry& grid, const std::vector<Collider>& colliders, double first, double last);

/// The nodes one cell behind the faces with mirror images, axis after axis, as far as their images are among `nodes`: a
/// particle that reaches the one reaches the other. Not collective.
std::vector<NodeImage> node_images(const GridGeometry& grid, const Faces& faces, const std::vector<Int3>& nodes);

/// v -> v after contact: sticky, slip, or separating with Coulomb friction (Stomakhin et al. 2013). Not collective.
Vec3 constrained_velocity(const NodeConstraint& constraint, const Vec3& velocity);

}  // namespace bulkley
