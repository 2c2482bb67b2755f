#include "grid/rigid_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/mass_properties.hpp"
#include "geometry/mesh_shape.hpp"
#include "geometry/surface.hpp"

namespace bulkley {

namespace {

// A guided body's velocity at the start is along its freedom, which the scene's rules make sure of.
double start_rate(const RigidBody& body, const Guide& guide) {
  return guide.direction.dot(guide.point ? body.angular_velocity : body.velocity);
}

}  // namespace

std::optional<std::string> mass_fault(const RigidBody& body) {
  bool closed = true;
  visit_meshes(body.shape, [&](const Mesh& mesh) { closed = closed && mesh.solid && mesh.solid->facts().closed(); });
  if (!closed) return "has a mesh with holes, which has no volume; close it";
  const std::optional<MassProperties> properties = mass_properties(body.shape);
  if (!properties)
    return "has a shape whose mass is not known: use a box, sphere, cylinder, capsule, ellipsoid or closed mesh, placed or "
           "not";
  if (!(properties->volume > 0.0)) return "encloses no volume";
  const Vec3 moments = principal_frame(properties->inertia).moments;
  if (!are_moments(moments))
    return fmt::format("has moments of inertia {:.3g} : {:.3g} : {:.3g}, which no solid has; its mesh intersects itself",
                       moments[0], moments[1], moments[2]);
  return std::nullopt;
}

RigidStart start_of(const RigidBody& body, double spacing) {
  const MassProperties properties = *mass_properties(body.shape);
  const double density = body.density ? *body.density : *body.mass / properties.volume;
  const PrincipalFrame frame = principal_frame(properties.inertia);
  RigidStart start;
  start.mass = {density * properties.volume, density * frame.moments};
  start.rest.center = properties.center;
  start.rest.rotation = Eigen::Quaterniond(frame.axes).normalized();
  start.state = start.rest;
  if (body.axis)
    start.guide = Guide{body.axis->normalized(), body.axis_point.value_or(properties.center)};
  else if (body.line)
    start.guide = Guide{body.line->normalized(), std::nullopt};
  start.state.momentum = start.mass.mass * body.velocity;
  start.state.angular_momentum = world_inertia(start.mass, start.rest) * body.angular_velocity;
  if (start.guide) set_rate(start.mass, *start.guide, start_rate(body, *start.guide), start.state);
  const TriangleMesh surface = surface_of(body.shape, bounds(body.shape));
  for (const Vec3& x : surface.vertices) start.reach = std::max(start.reach, (x - properties.center).norm());
  start.surface = contact_points(body.shape, spacing);
  return start;
}

Pose pose_of(const RigidStart& start, const RigidState& state) {
  const Mat3 rotation = (state.rotation * start.rest.rotation.conjugate()).toRotationMatrix();
  return {rotation, state.center - rotation * start.rest.center};
}

double reach_of_hold(const GridGeometry& grid, const RigidBody& body) {
  return body.contact == Contact::sticky ? hold_distance(grid, body.contact) : 0.0;
}

Vec3 nearest_arm(const GridGeometry& grid, const Vec3& center, const Vec3& point) {
  Vec3 arm = point - center;
  for (int a = 0; a < 3; ++a) {
    if (!grid.periodic[static_cast<std::size_t>(a)]) continue;
    const double period = grid.cell_size * grid.n_cells[static_cast<std::size_t>(a)];
    arm[a] -= period * std::nearbyint(arm[a] / period);
  }
  return arm;
}

std::optional<std::string> obstacle_of(const GridGeometry& grid, const std::vector<Collider>& colliders,
                                       const std::vector<RigidBody>& bodies, const std::vector<RigidStart>& starts,
                                       const std::vector<RigidState>& states, std::size_t number, double time,
                                       double allowed) {
  const Pose pose = pose_of(starts[number], states[number]);
  const Vec3 upper = grid.upper();
  std::vector<Pose> collider_poses, body_poses;
  for (const Collider& collider : colliders) collider_poses.push_back(collider.motion.pose(time));
  for (std::size_t b = 0; b < bodies.size(); ++b) body_poses.push_back(pose_of(starts[b], states[b]));
  for (const ContactPoint& rest : starts[number].surface) {
    const ContactPoint point = moved(rest, pose);
    const Vec3& x = point.place;
    for (int a = 0; a < 3; ++a) {
      if (grid.periodic[static_cast<std::size_t>(a)]) continue;
      const auto face = 2 * static_cast<std::size_t>(a);
      const double r =
          point.radius * Vec3::Unit(a).cross(point.axis.isZero(0.0) ? Vec3::Unit((a + 1) % 3) : point.axis).norm();
      if (!(x[a] - r >= grid.lower[a] - allowed)) return fmt::format("face {}", face_names[face]);
      if (!(x[a] + r <= upper[a] + allowed)) return fmt::format("face {}", face_names[face + 1]);
    }
    const auto reaches_into = [&](const Shape& shape, const Pose& other, const Vec3& shift) {
      ContactPoint shifted = point;
      shifted.place += shift;
      const auto place = nearest_place(shifted, [&](const Vec3& at) { return outward_normal(shape, other, at); });
      return place && signed_distance(shape, other, *place) < -allowed;
    };
    for (std::size_t c = 0; c < colliders.size(); ++c)
      if (reaches_into(colliders[c].shape, collider_poses[c], Vec3::Zero()))
        return fmt::format("collider '{}'", colliders[c].name);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (b == number) continue;
      const Vec3 arm = nearest_arm(grid, states[b].center, x);
      if (arm.norm() - point.radius <= starts[b].reach &&
          reaches_into(bodies[b].shape, body_poses[b], states[b].center + arm - x))
        return fmt::format("rigid body '{}'", bodies[b].name);
    }
  }
  return std::nullopt;
}

}  // namespace bulkley
