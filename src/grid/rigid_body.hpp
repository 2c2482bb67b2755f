#pragma once
// Free rigid bodies: what a scene says of them, their mass, and where they are among obstacles.

#include <optional>
#include <string>
#include <vector>

#include "config/formula.hpp"
#include "geometry/contact_points.hpp"
#include "geometry/free_motion.hpp"
#include "grid/boundary.hpp"

namespace bulkley {

/// An entry of [[rigid_bodies]].
struct RigidBody {
  std::string name;
  Shape shape;
  Contact contact = Contact::sticky;     ///< with the material
  double material_friction = 0.0;        ///< Coulomb coefficient with the material, separating only
  std::optional<double> density{};       ///< kg/m^3; this or the mass
  std::optional<double> mass{};          ///< kg
  Vec3 velocity = Vec3::Zero();          ///< m/s, at the start
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, at the start, about the centre of mass
  VectorFormula force;                   ///< N, formulas of t, at the centre of mass
  VectorFormula torque;                  ///< N m, formulas of t
  std::optional<Vec3> axis{};            ///< it only turns about this direction ...
  std::optional<Vec3> axis_point{};      ///< m, ... through here; none: through the centre of mass
  std::optional<Vec3> line{};            ///< or it only moves along this direction
  double spring = 0.0;                   ///< N/m, or N m/rad with an axis: back to where it begins
  double restitution = 0.0;              ///< rebound over approach in collisions
  double friction = 0.5;                 ///< Coulomb coefficient in collisions
};

/// A body as it begins, and its place in its own frame.
struct RigidStart {
  RigidMass mass;
  std::optional<Guide> guide;
  RigidState state;
  RigidState rest;                    ///< where the scene puts it, without motion
  std::vector<ContactPoint> surface;  ///< where the scene puts it
  double reach = 0.0;                 ///< m, no point is farther from the centre of mass
};

/// Why a body of this shape cannot move freely, as the end of a sentence that begins with its name; none if it can. Needs meshes. Not
/// collective.
std::optional<std::string> mass_fault(const RigidBody& body);
/// `spacing`: of points of its surface, m. Precondition: no fault. Not collective.
RigidStart start_of(const RigidBody& body, double spacing);
/// From where the scene puts it to where it is. Not collective.
Pose pose_of(const RigidStart& start, const RigidState& state);

/// How far in front of a body a node is still held, m. One that slips or separates holds the nodes behind its surface only: past a curved
/// body the normal velocity falls off within its radius, and nodes in front of it must not lose that. Not collective.
double reach_of_hold(const GridGeometry& grid, const RigidBody& body);

/// From a body's centre to a point of the domain: to the nearest of its images along periodic axes, m. Not collective.
Vec3 nearest_arm(const GridGeometry& grid, const Vec3& center, const Vec3& point);

/// What body `number` reaches into by more than `allowed`, m, at `time`: "face z_lower", "collider 'cup'", "rigid body 'ball'"; none
/// if nothing. Not collective.
std::optional<std::string> obstacle_of(const GridGeometry& grid, const std::vector<Collider>& colliders,
                                       const std::vector<RigidBody>& bodies, const std::vector<RigidStart>& starts,
                                       const std::vector<RigidState>& states, std::size_t number, double time,
                                       double allowed);

}  // namespace bulkley
