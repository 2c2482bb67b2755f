#include "grid/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

void check_friction(double friction, const std::string& where) {
  if (!(friction >= 0.0 && std::isfinite(friction)))
    throw UsageError(where + ": friction = " + std::to_string(friction) + " must be a finite number >= 0");
}

void check_faces(const GridGeometry& grid, const Faces& faces) {
  for (const FaceFault& fault : face_faults(faces))
    throw UsageError(std::string("face ") + face_names[fault.face] + (*fault.key == 0 ? "" : ".") + fault.key + " " +
                     fault.sentence);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (is_periodic(faces, axis) != grid.periodic[axis])
      throw UsageError(std::string("face ") + face_names[2 * axis] +
                       ": a face is periodic if and only if its axis of the grid is");
}

}  // namespace

// From indices, so that no rounding can move a wall.
int cells_inside(const GridGeometry& grid, int f, const Int3& node) {
  const int axis = f / 2;
  const int from_lower = node[static_cast<std::size_t>(axis)] - grid.node_offset(axis);
  return f % 2 == 0 ? from_lower : grid.n_cells[static_cast<std::size_t>(axis)] - from_lower;
}

// How far in front of a collider a node is still held, m. Where the nearest held nodes are far behind the surface, they
// have next to no weight left for the material at the surface, which slides past: with three quarters of a cell, a plane
// acts 0.3 cells behind to 0.6 in front of its position, depending on the nodes; with half a cell, up to 1.5 behind.
double hold_distance(const GridGeometry& grid, Contact contact) {
  return contact == Contact::separating ? 0.0 : 0.75 * grid.cell_size;
}

void settle_center(Collider& collider) {
  const Bounds b = bounds(collider.shape);
  if (collider.center)
    collider.motion.center = *collider.center;
  else if (b.lower.allFinite() && b.upper.allFinite())
    collider.motion.center = b.center();
}

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
      const std::optional<Contact> contact = behaviour(face.kind).contact;
      if (!contact || cells_inside(grid, f, node) > 0) continue;
      const double inward = f % 2 == 0 ? 1.0 : -1.0;
      result.push_back({index, *contact, face.friction, inward * Vec3::Unit(f / 2), face.velocity});
    }
    const Vec3 x = grid.node_position(node);
    for (std::size_t c = 0; c < colliders.size(); ++c) {
      const Collider& collider = colliders[c];
      if (!collider.motion.moves() && signed_distance(collider.shape, x) <= hold_distance(grid, collider.contact))
        result.push_back({index, collider.contact, collider.friction, outward_normal(collider.shape, x), Vec3::Zero(),
                          static_cast<std::int32_t>(c), x - collider.motion.center});
    }

    // A second wall may turn the velocity back into the first: the second round leaves at most cos^2 of their angle of it.
    const std::size_t last = result.size();
    if (last - first > 1)
      for (std::size_t c = first; c < last; ++c) result.push_back(NodeConstraint(result[c]));
  }
  return result;
}

MovingConstraints::MovingConstraints(const GridGeometry& grid, const std::vector<Collider>& colliders,
                                     std::vector<Int3> nodes, std::vector<LocalIndex> places,
                                     std::vector<NodeConstraint> fixed)
    : grid_(grid), colliders_(colliders), nodes_(std::move(nodes)), places_(std::move(places)), fixed_(std::move(fixed)) {
  const auto same = [](const NodeConstraint& a, const NodeConstraint& b) {
    return a.node == b.node && a.collider == b.collider && a.normal == b.normal;
  };
  // node_constraints gives them by node already, repeated as a whole.
  std::size_t kept = 0;
  for (std::size_t f = 0; f < fixed_.size(); ++f) {
    std::size_t first = kept;
    while (first > 0 && fixed_[first - 1].node == fixed_[f].node) --first;
    const auto begin = fixed_.begin() + static_cast<std::ptrdiff_t>(first),
               end = fixed_.begin() + static_cast<std::ptrdiff_t>(kept);
    if (std::none_of(begin, end, [&](const NodeConstraint& c) { return same(c, fixed_[f]); })) fixed_[kept++] = fixed_[f];
  }
  fixed_.resize(kept);
}

// The nodes that collider `number` holds.
void MovingConstraints::add_collider(std::size_t number, double time, double dt) {
  const Collider& collider = colliders_[number];
  const Pose pose = collider.motion.pose(time);
  const RigidVelocity velocity = collider.motion.velocity_at(time + 0.5 * dt);
  const Vec3 center = pose.to_world(collider.motion.center);
  const double held = hold_distance(grid_, collider.contact);
  const Bounds box = bounds(collider.shape, pose);
  // The box in node indices, one node larger for rounding; ints hold every node's index, infinities do not fit.
  Int3 first, last;
  for (int a = 0; a < 3; ++a) {
    const double lowest = (box.lower[a] - held - grid_.lower[a]) / grid_.cell_size + grid_.node_offset(a);
    const double highest = (box.upper[a] + held - grid_.lower[a]) / grid_.cell_size + grid_.node_offset(a);
    const auto axis = static_cast<std::size_t>(a);
    first[axis] = static_cast<int>(std::floor(std::clamp(lowest, 0.0, 1.0 * grid_.n_nodes(a)))) - 1;
    last[axis] = static_cast<int>(std::ceil(std::clamp(highest, 0.0, 1.0 * grid_.n_nodes(a)))) + 1;
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Int3& node = nodes_[n];
    if (node[0] < first[0] || node[0] > last[0] || node[1] < first[1] || node[1] > last[1] || node[2] < first[2] ||
        node[2] > last[2])
      continue;
    const Vec3 x = grid_.node_position(node);
    if (signed_distance(collider.shape, pose, x) > held) continue;
    touching_.push_back({static_cast<LocalIndex>(n), collider.contact, collider.friction,
                         outward_normal(collider.shape, pose, x), velocity.at(x), static_cast<std::int32_t>(number),
                         x - center});
  }
}

const std::vector<NodeConstraint>& MovingConstraints::at(double time, double dt) {
  touching_.clear();
  result_.clear();
  for (std::size_t c = 0; c < colliders_.size(); ++c)
    if (colliders_[c].motion.moves()) add_collider(c, time, dt);
  const auto by_node = [](const NodeConstraint& a, const NodeConstraint& b) { return a.node < b.node; };
  std::stable_sort(touching_.begin(), touching_.end(), by_node);
  auto wall = fixed_.begin();
  for (auto first = touching_.begin(); first != touching_.end();) {
    const auto last = std::upper_bound(first, touching_.end(), *first, by_node);
    wall = std::lower_bound(wall, fixed_.end(), *first, by_node);
    const auto wall_end = std::upper_bound(wall, fixed_.end(), *first, by_node);
    result_.insert(result_.end(), first, last);
    if ((last - first) + (wall_end - wall) > 1) {
      result_.insert(result_.end(), wall, wall_end);
      result_.insert(result_.end(), first, last);
    }
    first = last;
  }
  for (NodeConstraint& constraint : result_) constraint.node = places_[static_cast<std::size_t>(constraint.node)];
  return result_;
}

std::size_t MovingConstraints::memory() const {
  return nodes_.capacity() * sizeof(Int3) + places_.capacity() * sizeof(LocalIndex) +
         (fixed_.capacity() + touching_.capacity() + result_.capacity()) * sizeof(NodeConstraint);
}

double collider_speed(const GridGeometry& grid, const std::vector<Collider>& colliders, double first, double last) {
  double fastest = 0.0;
  for (const Collider& collider : colliders) {
    const RigidMotion& motion = collider.motion;
    if (!motion.moves()) continue;
    Bounds box = bounds(collider.shape);
    // Of an endless obstacle, the part inside the domain, independent of its centre.
    if (!box.lower.allFinite() || !box.upper.allFinite()) {
      const Vec3 begin = motion.pose(first).to_world(motion.center), end = motion.pose(last).to_world(motion.center);
      box = {grid.lower + motion.center - begin.cwiseMax(end), grid.upper() + motion.center - begin.cwiseMin(end)};
    }
    const Vec3 farthest = (box.lower - motion.center).cwiseAbs().cwiseMax((box.upper - motion.center).cwiseAbs());
    fastest = std::max(fastest, motion.speed_bound(first, last, farthest.norm()));
  }
  return fastest;
}

std::vector<MirrorPair> mirror_pairs(const GridGeometry& grid, int f, const std::vector<Int3>& nodes) {
  std::vector<std::pair<Int3, LocalIndex>> front;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    if (cells_inside(grid, f, nodes[n]) == 1) front.emplace_back(nodes[n], static_cast<LocalIndex>(n));
  std::sort(front.begin(), front.end());
  std::vector<MirrorPair> pairs;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (cells_inside(grid, f, nodes[n]) != -1) continue;
    Int3 image = nodes[n];
    image[static_cast<std::size_t>(f / 2)] += f % 2 == 0 ? 2 : -2;
    const auto found = std::lower_bound(front.begin(), front.end(), std::pair(image, LocalIndex{0}));
    if (found != front.end() && found->first == image) pairs.push_back({static_cast<LocalIndex>(n), found->second});
  }
  return pairs;
}

std::vector<NodeImage> node_images(const GridGeometry& grid, const Faces& faces, const std::vector<Int3>& nodes) {
  check_faces(grid, faces);
  std::vector<NodeImage> result;
  for (int f = 0; f < 6; ++f) {
    const Face& face = faces[static_cast<std::size_t>(f)];
    const NodesBehind behind = behaviour(face.kind).behind;
    if (behind == NodesBehind::free) continue;
    Vec3 sign = Vec3::Constant(behind == NodesBehind::reversed ? -1.0 : 1.0);
    sign[f / 2] = -1.0;
    for (const MirrorPair& pair : mirror_pairs(grid, f, nodes)) result.push_back({pair.behind, pair.front, sign, face.velocity, f});
  }
  return result;
}

Vec3 constrained_velocity(const NodeConstraint& constraint, const Vec3& velocity) {
  const Vec3& wall = constraint.velocity;
  if (constraint.contact == Contact::sticky) return wall;
  const Vec3 relative = velocity - wall;
  const double normal_speed = relative.dot(constraint.normal);
  const Vec3 tangential = relative - normal_speed * constraint.normal;
  if (constraint.contact == Contact::slip) return wall + tangential;
  if (normal_speed >= 0.0) return velocity;
  // Coulomb: the wall takes at most friction x |normal impulse| from the tangential velocity.
  const double loss = -constraint.friction * normal_speed;
  const double speed = tangential.norm();
  if (speed <= loss) return wall;
  return wall + tangential * (1.0 - loss / speed);
}

}  // namespace bulkley
