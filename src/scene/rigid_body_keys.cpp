#include "scene/rigid_body_keys.hpp"

#include <fmt/format.h>

#include "scene/boundary_keys.hpp"
#include "scene/shape_keys.hpp"

namespace bulkley {

namespace {

constexpr std::size_t most_bodies = 1000;

/// A guide leaves one freedom; what acts or moves outside of it is a mistake.
void check_guide(const config::Value& table, const RigidBody& body, config::Faults& faults) {
  const auto fault = [&](const char* key, const std::string& sentence) {
    faults.add(table.find(key)->place, fmt::format("'{}.{}' {}", table.path, key, sentence));
  };
  if (body.axis && body.line)
    return fault("line", "is given beside 'axis': a body turns about an axis or moves along a line");
  if (body.axis_point && !body.axis) return fault("axis_point", "has no 'axis' through it");
  for (const auto& [key, direction] : {std::pair{"axis", body.axis}, {"line", body.line}})
    if (direction && !(direction->norm() > 0.0)) return fault(key, "has no length; it must not be [0, 0, 0]");
  const auto off = [](const Vec3& vector, const std::optional<Vec3>& direction) {
    return !direction || vector.cross(*direction).norm() > 1e-9 * vector.norm() * direction->norm();
  };
  if (body.axis || body.line) {
    if (body.velocity.norm() > 0.0 && off(body.velocity, body.line))
      fault("velocity", body.axis ? "is given with an 'axis': give the 'angular_velocity' about it" : "is not along 'line'");
    if (body.angular_velocity.norm() > 0.0 && off(body.angular_velocity, body.axis))
      fault("angular_velocity",
            body.axis ? "is not along 'axis'" : "is given with a 'line', along which a body does not turn");
  }
  if (body.line && body.torque.given()) fault("torque", "is given with a 'line', along which a body does not turn");
}

void check_body(const config::Value& table, RigidBody& body, config::Faults& faults) {
  if (body.density.has_value() == body.mass.has_value())
    faults.add(table.place, fmt::format("rigid body '{}' needs a 'density' or a 'mass', one of the two", body.name));
  check_guide(table, body, faults);
}

}  // namespace

const config::Keys<RigidBody>& keys(config::Of<RigidBody>) {
  static const auto table =
      config::Keys<RigidBody>(
          "A solid body that gravity and the material move. history.csv contains its position, velocity and spin, and the "
          "force and the "
          "torque about its centre of mass by the material, averaged since the previous row.")
          .key("name", &RigidBody::name,
               {.about = "Name in messages and columns; different for each body and collider.", .required = true})
          .key("shape", &RigidBody::shape,
               {.about = "Initial geometry: a box, sphere, cylinder, capsule, ellipsoid or closed mesh.", .required = true})
          .key("density", &RigidBody::density,
               {.about = "Mass per volume, the same everywhere in the body.",
                .unit = "kg/m^3",
                .range = config::above(0.0),
                .default_text = "from `mass`"})
          .key("mass", &RigidBody::mass,
               {.about = "Mass, spread evenly over the body, instead of the density.",
                .unit = "kg",
                .range = config::above(0.0),
                .default_text = "from `density`"})
          .key("contact", &RigidBody::contact,
               {.about = "sticky: material moves with the surface; slip: it moves along the surface and never leaves it; "
                         "separating: it may also leave, with `material_friction`."})
          .key("material_friction", &RigidBody::material_friction,
               {.about = "Coulomb coefficient between the body and material.", .range = config::at_least(0.0)})
          .only_with("contact = \"separating\"", [](const RigidBody& body) { return body.contact == Contact::separating; })
          .key("velocity", &RigidBody::velocity, {.about = "Velocity of the centre of mass at the start.", .unit = "m/s"})
          .key("angular_velocity", &RigidBody::angular_velocity,
               {.about = "Spin about the centre of mass at the start.", .unit = "rad/s"})
          .key("force", &RigidBody::force,
               {.about = "Force at the centre of mass, formulas of the time.",
                .unit = "N",
                .names = {"t"},
                .default_text = "none"})
          .key("torque", &RigidBody::torque,
               {.about = "Torque, formulas of the time.", .unit = "N m", .names = {"t"}, .default_text = "none"})
          .key("axis", &RigidBody::axis,
               {.about = "The body only turns, about a fixed axis of this direction.", .default_text = "none"})
          .key("axis_point", &RigidBody::axis_point,
               {.about = "A point of the axis.", .unit = "m", .default_text = "the centre of mass"})
          .key("line", &RigidBody::line,
               {.about = "The body only moves along this direction, and does not turn.", .default_text = "none"})
          .key("spring", &RigidBody::spring,
               {.about = "Stiffness of a spring to where the body begins: on the centre of mass, or, with an `axis`, on the "
                         "turn about "
                         "it.",
                .unit = "N/m, or N m/rad",
                .range = config::at_least(0.0)})
          .key("restitution", &RigidBody::restitution,
               {.about = "Speed of rebound over speed of impact where it collides with walls, colliders and other bodies; "
                         "between two bodies the smaller one.",
                .range = config::between(0.0, 1.0)})
          .key(
              "friction", &RigidBody::friction,
              {.about =
                   "Coulomb coefficient in collisions with walls, colliders and bodies; between two bodies the smaller one.",
               .range = config::at_least(0.0)})
          .check(check_body);
  return table;
}

void join_rigid_bodies(const config::Value& root, Scene& scene, config::Faults& faults) {
  const config::Value* const list = root.find("rigid_bodies");
  if (!list || list->items.empty()) return;
  for (const config::Value& entry : list->items) {
    scene.rigid_places.push_back(entry.place.text());
    const config::Value* const name = entry.find("name");
    for (const Collider& collider : scene.colliders)
      if (column_prefix(collider.name) == column_prefix(name->text))
        faults.add(name->place,
                   fmt::format("'{}' is \"{}\", which a collider has already: their columns in history.csv would "
                               "have the same names",
                               name->path, name->text));
  }
  if (list->items.size() > most_bodies)
    faults.add(list->place,
               fmt::format("'rigid_bodies' has {} entries; at most {} are possible", list->items.size(), most_bodies));
  if (scene.time_stepping.viscosity == ViscosityKind::implicit_stress)
    faults.add(list->place,
               "'rigid_bodies' needs explicit viscosity: the system of time.viscosity = \"implicit\" does not "
               "contain the bodies");
  if (scene.time_stepping.integrator == IntegratorKind::imex && scene.time_stepping.pressure.solver == PressureSolver::petsc)
    faults.add(list->place,
               "'rigid_bodies' needs time.pressure.solver = \"cg\": the matrix that PETSc gets has no rows of bodies");
}

}  // namespace bulkley
