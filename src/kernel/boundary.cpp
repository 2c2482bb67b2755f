#include "bulkley/kernel/boundary.hpp"

#include <cmath>
#include <map>
#include <optional>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

constexpr std::array<const char*, 6> face_names = {"x lower", "x upper", "y lower", "y upper", "z lower", "z upper"};

/// What a face does to the nodes on and behind it; nothing if it lets material pass.
std::optional<Contact> contact_of(FaceKind kind) {
  switch (kind) {
    case FaceKind::sticky:
      return Contact::sticky;
    case FaceKind::slip:
      return Contact::slip;
    case FaceKind::separating:
      return Contact::separating;
    case FaceKind::periodic:
    case FaceKind::outflow:
    case FaceKind::open:
      break;
  }
  return std::nullopt;
}

void check_friction(double friction, const std::string& where) {
  if (!(friction >= 0.0 && std::isfinite(friction)))
    throw UsageError(where + ": friction = " + std::to_string(friction) + " must be a finite number >= 0");
}

void check_faces(const GridGeometry& grid, const Faces& faces) {
  for (int f = 0; f < 6; ++f) {
    const Face& face = faces[static_cast<std::size_t>(f)];
    const std::string where = std::string("face ") + face_names[static_cast<std::size_t>(f)];
    if ((face.kind == FaceKind::periodic) != grid.periodic[static_cast<std::size_t>(f / 2)])
      throw UsageError(where + ": a face is periodic if and only if its axis and the opposite face are");
    check_friction(face.friction, where);
    if (!face.velocity.allFinite() || face.velocity[f / 2] != 0.0)
      throw UsageError(where + ": its velocity must be finite and along the face");
  }
}

/// Cells from face f to the node, positive inside the domain. From indices, so that no rounding can move a wall.
int cells_inside(const GridGeometry& grid, int f, const Int3& node) {
  const int axis = f / 2;
  const int from_lower = node[static_cast<std::size_t>(axis)] - grid.node_offset(axis);
  return f % 2 == 0 ? from_lower : grid.n_cells[static_cast<std::size_t>(axis)] - from_lower;
}

/// How far in front of a collider a node is still held, m. Where the nearest held nodes are far behind the surface, they have next
/// to no weight left for the material at the surface, which slides past: with three quarters of a cell, a plane acts 0.3 cells
/// behind to 0.6 in front of where it is stated, wherever it stands between the nodes; with half a cell, up to 1.5 behind.
double reach(const GridGeometry& grid, Contact contact) {
  return contact == Contact::separating ? 0.0 : 0.75 * grid.cell_size;
}

}  // namespace

std::vector<NodeConstraint> node_constraints(const GridGeometry& grid, const Faces& faces,
                                             const std::vector<Collider>& colliders, const std::vector<Int3>& nodes) {
  check_faces(grid, faces);
  for (const Collider& collider : colliders) {
    const std::string owner = "collider '" + collider.name + "'";
    check_shape(collider.shape, owner);
    check_friction(collider.friction, owner);
  }

  std::vector<NodeConstraint> result;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Int3& node = nodes[n];
    const auto index = static_cast<LocalIndex>(n);
    const std::size_t first = result.size();
    for (int f = 0; f < 6; ++f) {
      const Face& face = faces[static_cast<std::size_t>(f)];
      const std::optional<Contact> contact = contact_of(face.kind);
      if (!contact || cells_inside(grid, f, node) > 0) continue;
      const double inward = f % 2 == 0 ? 1.0 : -1.0;
      result.push_back({index, *contact, face.friction, inward * Vec3::Unit(f / 2), face.velocity});
    }
    const Vec3 x(grid.node_coordinate(0, node[0]), grid.node_coordinate(1, node[1]), grid.node_coordinate(2, node[2]));
    for (const Collider& collider : colliders)
      if (signed_distance(collider.shape, x) <= reach(grid, collider.contact))
        result.push_back({index, collider.contact, collider.friction, outward_normal(collider.shape, x), Vec3::Zero()});

    // A second wall may turn the velocity back into the first: the second round leaves at most cos^2 of their angle of it.
    const std::size_t last = result.size();
    if (last - first > 1)
      for (std::size_t c = first; c < last; ++c) result.push_back(NodeConstraint(result[c]));
  }
  return result;
}

std::vector<NodeImage> node_images(const GridGeometry& grid, const Faces& faces, const std::vector<Int3>& nodes) {
  check_faces(grid, faces);
  std::vector<NodeImage> result;
  for (int f = 0; f < 6; ++f) {
    const Face& face = faces[static_cast<std::size_t>(f)];
    if (face.kind != FaceKind::sticky && face.kind != FaceKind::slip) continue;
    std::map<Int3, LocalIndex> front;
    for (std::size_t n = 0; n < nodes.size(); ++n)
      if (cells_inside(grid, f, nodes[n]) == 1) front[nodes[n]] = static_cast<LocalIndex>(n);
    Vec3 sign = Vec3::Constant(face.kind == FaceKind::sticky ? -1.0 : 1.0);
    sign[f / 2] = -1.0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (cells_inside(grid, f, nodes[n]) != -1) continue;
      Int3 image = nodes[n];
      image[static_cast<std::size_t>(f / 2)] += f % 2 == 0 ? 2 : -2;
      if (const auto found = front.find(image); found != front.end())
        result.push_back({static_cast<LocalIndex>(n), found->second, sign, face.velocity});
    }
  }
  return result;
}

Vec3 constrained_velocity(const NodeConstraint& constraint, const Vec3& velocity) {
  if (constraint.contact == Contact::sticky) return constraint.velocity;
  const double normal_speed = velocity.dot(constraint.normal);
  const Vec3 tangential = velocity - normal_speed * constraint.normal;
  if (constraint.contact == Contact::slip) return tangential;
  if (normal_speed >= 0.0) return velocity;
  // Coulomb: the wall takes at most friction x |normal impulse| from the tangential velocity.
  const double loss = -constraint.friction * normal_speed;
  const double speed = tangential.norm();
  if (speed <= loss) return Vec3::Zero();
  return tangential * (1.0 - loss / speed);
}

}  // namespace bulkley
